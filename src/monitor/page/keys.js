// The page by keyboard.

const PANELS = ["health", "ranges", "plan", "control", "doppler", "errors", "ppi"];

/** `acts` has what a key does: [key, words, action]. */
export function init(acts) {
  const dialog = document.getElementById("keys");
  const big = (section) => {
    const was = section.classList.contains("big");
    document.querySelectorAll("section.big").forEach((one) => one.classList.remove("big"));
    document.body.classList.toggle("one", !was);
    section.classList.toggle("big", !was);
  };
  const focused = () => document.activeElement?.closest("section") ?? document.getElementById("p-ranges");
  const all = [
    ["1 … 7", "go to a panel (7: plan position, of a scanning antenna)", null],
    ["f", "this panel alone, and back", () => big(focused())],
    ...acts,
    ["arrows + −", "move and scale the plan, while it has the focus; scale the plan position", null],
    ["?", "these keys", () => dialog.showModal()],
    ["Esc", "back", null],
  ];
  document.getElementById("keys-list").replaceChildren(...all.flatMap(([key, words]) => [
    Object.assign(document.createElement("dt"), { textContent: key }),
    Object.assign(document.createElement("dd"), { textContent: words }),
  ]));
  document.getElementById("help").onclick = () => dialog.showModal();
  for (const name of PANELS) {
    const section = document.getElementById(`p-${name}`);
    section.querySelector("h2").ondblclick = () => big(section);
  }
  document.addEventListener("keydown", (event) => {
    const typing = ["INPUT", "SELECT", "TEXTAREA"].includes(event.target.tagName) && event.target.type !== "checkbox";
    if (event.ctrlKey || event.altKey || event.metaKey || (typing && event.key !== "Escape")) return;
    if (event.key === "Escape") {
      if (document.body.classList.contains("one")) big(document.querySelector("section.big"));
      document.activeElement?.blur?.();
      return;
    }
    const number = Number(event.key);
    if (number >= 1 && number <= PANELS.length) {
      const section = document.getElementById(`p-${PANELS[number - 1]}`);
      if (section.hidden) return;
      section.focus();
      section.scrollIntoView({ block: "nearest" });
      return;
    }
    const act = all.find(([key, , action]) => action && key === event.key)?.[2];
    if (act) {
      event.preventDefault();
      act();
    }
  });
}
