//! Cut files of GRASP: complex far fields along cuts through the boresight.
//!
//! Cuts follow one another: a line of text, a line with `V_INI V_INC V_NUM C ICOMP ICUT NCOMP`, and `V_NUM`
//! lines with real and imaginary part of each component.
//!
//! - `ICUT` 1: theta, from the boresight, changes along a cut, phi is `C`.
//! - `ICOMP` 3: co- and cross-polar fields of Ludwig's third definition; the first is taken. 1: fields along
//!   theta and phi; of those along x and y by Ludwig that with more power is taken.
//! - `|E|^2` is the power gain: a file's whole power is 4 pi.
//!
//! GRASP looks along z. Its x becomes +y of the antenna here (left), its y +z (up). Fields between cuts and
//! angles are bilinear.

use num_complex::Complex64;

use super::axis::{Axis, Gridded};
use super::columns::MOST_POINTS;
use super::fault::{Faults, PatternFault};

/// Most degrees of phi from cut to cut.
const WIDEST_DEG: f64 = 90.0;
const HEADER: &str = "V_INI V_INC V_NUM C ICOMP ICUT NCOMP, seven numbers";

/// What all cuts have in common.
#[derive(Clone, Copy, PartialEq)]
struct Head {
    first_deg: f64,
    step_deg: f64,
    count: usize,
    component: u32,
}

impl Head {
    fn farthest_deg(self) -> f64 {
        self.first_deg + self.step_deg * (self.count - 1) as f64
    }

    /// An axis of the grid to either side of the boresight, within so many degrees.
    fn axis(self, most_deg: f64) -> Axis {
        let step_deg = self.step_deg;
        let half = (self.farthest_deg().min(most_deg) / step_deg + 1e-6).floor() as usize;
        Axis { first_deg: -(half as f64) * step_deg, step_deg, len: 2 * half + 1 }
    }
}

/// A cut: its phi, degrees, and both components at every theta.
struct Cut {
    phi_deg: f64,
    fields: Vec<[Complex64; 2]>,
}

impl Cut {
    /// The same cut from the other side, half a turn on: fields along theta and phi change their sign there.
    fn turn(&mut self, component: u32) {
        self.phi_deg = (self.phi_deg - 180.0).max(0.0);
        self.fields.reverse();
        if component == 1 {
            self.fields.iter_mut().flatten().for_each(|field| *field = -*field);
        }
    }
}

/// A number as Fortran writes it: with D, or without any letter before a long exponent.
fn number(text: &str) -> Option<f64> {
    let plain = text.replace(['d', 'D'], "e");
    plain.parse().ok().or_else(|| {
        let sign = plain.get(1..)?.rfind(['+', '-'])? + 1;
        format!("{}e{}", &plain[..sign], &plain[sign..]).parse().ok()
    })
}

fn numbers(line: &str) -> Option<Vec<f64>> {
    let all: Option<Vec<f64>> = line.split_whitespace().map(number).collect();
    all.filter(|numbers| numbers.iter().all(|number| number.is_finite()))
}

/// Reads the text of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Gridded, Vec<PatternFault>> {
    let text = String::from_utf8_lossy(bytes);
    let mut faults = Faults::default();
    let mut lines = (1u64..).zip(text.lines());
    let (mut head, mut cuts): (Option<Head>, Vec<Cut>) = (None, Vec::new());
    // Empty lines at the end are none.
    while !lines.clone().all(|(_, line)| line.trim().is_empty())
        && let Some((_, text)) = lines.next()
    {
        let Some((line, header)) = lines.next() else {
            if !text.trim().is_empty() {
                faults.push(PatternFault::Lacks { what: format!("the last cut has no line of {HEADER}") });
            }
            break;
        };
        let mut wrong = |line, found: &str, wanted| {
            let found = found.trim().chars().take(60).collect();
            faults.push(PatternFault::Line { line, found, wanted });
        };
        let (own, phi_deg) = match head_of(header) {
            Ok(found) => found,
            Err(wanted) => {
                wrong(line, header, wanted);
                // Nothing after it can be told apart.
                break;
            }
        };
        if *head.get_or_insert(own) != own {
            wrong(line, header, "the same angles and components in every cut");
            break;
        }
        let mut fields = Vec::with_capacity(own.count);
        for (line, row) in lines.by_ref().take(own.count) {
            match numbers(row).as_deref() {
                Some([a, b, c, d, ..]) => fields.push([Complex64::new(*a, *b), Complex64::new(*c, *d)]),
                _ => {
                    wrong(line, row, "real and imaginary parts of two components or more");
                    fields.push([Complex64::ZERO; 2]);
                }
            }
        }
        if fields.len() < own.count {
            let (found, wanted) = (fields.len(), own.count);
            faults.push(PatternFault::Lacks { what: format!("the last cut has {found} lines of {wanted}") });
            break;
        }
        let mut cut = Cut { phi_deg, fields };
        if own.first_deg < 0.0 && phi_deg > 180.0 - 1e-6 {
            cut.turn(own.component);
        }
        cuts.push(cut);
    }
    let Some(head) = head else {
        faults.push(PatternFault::Lacks {
            what: "no cut: a line of text and one of seven numbers wanted".into(),
        });
        return Err(faults.finish());
    };
    cuts.sort_by(|a, b| a.phi_deg.total_cmp(&b.phi_deg));
    let span_deg = if head.first_deg < 0.0 { 180.0 } else { 360.0 };
    // What closes the circle says nothing new.
    cuts.dedup_by(|later, earlier| later.phi_deg - earlier.phi_deg < 1e-6);
    let around = cuts.first().map_or(0.0, |cut| cut.phi_deg) + span_deg;
    let next = cuts.iter().skip(1).map(|cut| cut.phi_deg).chain([around]);
    let widest_deg = cuts.iter().zip(next).fold(0.0, |most: f64, (cut, next)| most.max(next - cut.phi_deg));
    if widest_deg > WIDEST_DEG + 1e-6 {
        let what = format!("no cut within {widest_deg:.1} degrees of phi; at most {WIDEST_DEG} wanted");
        faults.push(PatternFault::Lacks { what });
    }
    if head.axis(180.0).len.saturating_mul(head.axis(90.0).len) > MOST_POINTS {
        faults.push(PatternFault::TooMany);
    }
    if !faults.list.is_empty() {
        return Err(faults.finish());
    }
    Ok(Sphere::new(head, cuts, span_deg).gridded())
}

/// The common part of a cut's second line, and its phi, degrees.
fn head_of(line: &str) -> Result<(Head, f64), &'static str> {
    let found = numbers(line).ok_or(HEADER)?;
    let [first_deg, step_deg, count, phi_deg, component, cut, components] = found[..] else {
        return Err(HEADER);
    };
    let whole = |value: f64, least: f64, most: f64| value.fract() == 0.0 && (least..=most).contains(&value);
    if !whole(count, 3.0, 100_000.0) || step_deg < 0.001 {
        return Err("V_NUM from 3 to 100000, V_INC from 0.001 degrees on");
    }
    let farthest_deg = first_deg + step_deg * (count - 1.0);
    let through = first_deg < 0.0 && (first_deg + farthest_deg).abs() < 1e-3;
    if !(first_deg == 0.0 || through) || farthest_deg > 180.001 {
        return Err("V_INI 0, or as far below 0 as the last angle is above it, up to 180 degrees");
    }
    if !(-360.0..=360.0).contains(&phi_deg) {
        return Err("C from -360 to 360 degrees");
    }
    if cut != 1.0 {
        return Err("ICUT 1 (theta along a cut)");
    }
    if !(component == 1.0 || component == 3.0) || !whole(components, 2.0, 3.0) {
        return Err("ICOMP 1 or 3 and NCOMP 2 or 3");
    }
    let head = Head { first_deg, step_deg, count: count as usize, component: component as u32 };
    Ok((head, phi_deg.rem_euclid(360.0)))
}

/// One component on the sphere.
struct Sphere {
    head: Head,
    span_deg: f64,
    /// Rising phi, and the fields along it.
    cuts: Vec<(f64, Vec<Complex64>)>,
}

impl Sphere {
    fn new(head: Head, cuts: Vec<Cut>, span_deg: f64) -> Self {
        let along = |of: fn(f64, [Complex64; 2]) -> Complex64| -> Vec<(f64, Vec<Complex64>)> {
            let line = |cut: &Cut| {
                let phi = cut.phi_deg.to_radians();
                (cut.phi_deg, cut.fields.iter().map(|fields| of(phi, *fields)).collect())
            };
            cuts.iter().map(line).collect()
        };
        let power = |cuts: &[(f64, Vec<Complex64>)]| -> f64 {
            cuts.iter().flat_map(|(_, fields)| fields).map(Complex64::norm_sqr).sum()
        };
        let cuts = if head.component == 3 {
            along(|_, [co, _]| co)
        } else {
            let x = along(|phi, [theta, around]| theta * phi.cos() - around * phi.sin());
            let y = along(|phi, [theta, around]| theta * phi.sin() + around * phi.cos());
            if power(&x) >= power(&y) { x } else { y }
        };
        Self { head, span_deg, cuts }
    }

    /// Towards theta and phi, degrees; `None` beyond the cuts.
    fn at(&self, theta_deg: f64, phi_deg: f64) -> Option<Complex64> {
        if theta_deg > self.head.farthest_deg() + 1e-6 {
            return None;
        }
        // A cut from the left to the right has the other half at theta below 0.
        let back = phi_deg >= self.span_deg;
        let (theta_deg, phi_deg) =
            if back { (-theta_deg, phi_deg - self.span_deg) } else { (theta_deg, phi_deg) };
        let after = self.cuts.partition_point(|(phi, _)| *phi <= phi_deg);
        let turned = |n: usize, by_deg: f64| {
            // Around the end of the span theta changes its sign where cuts go through the boresight.
            let (phi, fields) = &self.cuts[n];
            let mirrored = by_deg != 0.0 && self.span_deg < 360.0;
            (phi + by_deg, self.along(fields, if mirrored { -theta_deg } else { theta_deg }))
        };
        let last = self.cuts.len() - 1;
        let (from, from_field) =
            if after == 0 { turned(last, -self.span_deg) } else { turned(after - 1, 0.0) };
        let (to, to_field) = if after > last { turned(0, self.span_deg) } else { turned(after, 0.0) };
        let s = (phi_deg - from) / (to - from);
        Some(from_field * (1.0 - s) + to_field * s)
    }

    fn along(&self, fields: &[Complex64], theta_deg: f64) -> Complex64 {
        let place = (theta_deg - self.head.first_deg) / self.head.step_deg;
        let from = (place.max(0.0) as usize).min(fields.len() - 2);
        let s = (place - from as f64).clamp(0.0, 1.0);
        fields[from] * (1.0 - s) + fields[from + 1] * s
    }

    fn gridded(&self) -> Gridded {
        let (mut azimuth, elevation) = (self.head.axis(180.0), self.head.axis(90.0));
        if azimuth.first_deg < -180.0 + 1e-6 {
            // 180 and -180 degrees are the same.
            azimuth.len -= 1;
        }
        let mut field = Vec::with_capacity(azimuth.len * elevation.len);
        for row in 0..elevation.len {
            let (up, level) = elevation.value_deg(row).to_radians().sin_cos();
            for column in 0..azimuth.len {
                let (left, ahead) = azimuth.value_deg(column).to_radians().sin_cos();
                let [x, y, z] = [level * ahead, level * left, up];
                let theta_deg = y.hypot(z).atan2(x).to_degrees();
                let phi_deg = z.atan2(y).to_degrees().rem_euclid(360.0);
                field.push(self.at(theta_deg, if phi_deg < 360.0 { phi_deg } else { 0.0 }));
            }
        }
        Gridded { azimuth, elevation, field }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a beam of elliptic section that squints to the left, with a phase that turns.
    fn field(y: f64, z: f64) -> Complex64 {
        Complex64::from_polar(
            20.0 * (-(((y - 0.1) / 0.2).powi(2) + (z / 0.1).powi(2))).exp(),
            3.0 * y + 2.0 * z,
        )
    }

    fn file(first: f64, component: u32) -> String {
        file_from(0, first, component)
    }

    /// Cuts from a phi on.
    fn file_from(from: i32, first: f64, component: u32) -> String {
        let (span, mut text) = (if first < 0.0 { 180 } else { 360 }, String::new());
        for phi in (from..from + span).step_by(3) {
            let count = (30.0 - first) / 0.5 + 1.0;
            text += &format!("Field at phi {phi}\n {first} 0.5 {count} {phi} {component} 1 2\n");
            for n in 0..count as usize {
                let (theta, phi) = ((first + 0.5 * n as f64).to_radians(), f64::from(phi).to_radians());
                let co = field(theta.sin() * phi.cos(), theta.sin() * phi.sin());
                // Along y of Ludwig: theta sin + phi cos.
                let [a, b] =
                    if component == 3 { [co, Complex64::ZERO] } else { [co * phi.sin(), co * phi.cos()] };
                text += &format!(" {:.9E} {:.9E} {:.9E} {:.9E}\n", a.re, a.im, b.re, b.im).replace('E', "D");
            }
        }
        text
    }

    #[test]
    fn fields_are_those_of_the_beam() {
        let cuts = [(0, -30.0, 3), (0, 0.0, 3), (0, -30.0, 1), (0, 0.0, 1), (-90, -30.0, 3), (-90, -30.0, 1)];
        for (from, first, component) in cuts {
            let text = file_from(from, first, component) + "\n\n";
            let found = read(text.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}"));
            let (mut worst, mut seen) = (0.0f64, 0);
            for row in 0..found.elevation.len {
                for column in 0..found.azimuth.len {
                    let [az, el] = [found.azimuth.value_deg(column), found.elevation.value_deg(row)]
                        .map(f64::to_radians);
                    let wanted = field(el.cos() * az.sin(), el.sin());
                    let Some(own) = found.field[row * found.azimuth.len + column] else { continue };
                    worst = worst.max((own - wanted).norm());
                    seen += 1;
                }
            }
            println!("{first} {component}: {worst:.4} of 20, {seen} directions");
            assert!(worst < 0.05 && seen > 10_000, "{worst} {seen}");
        }
    }

    #[test]
    fn numbers_of_fortran() {
        assert_eq!(["1.5D-3", "-0.25-101", "3"].map(number), [Some(1.5e-3), Some(-0.25e-101), Some(3.0)]);
    }

    #[test]
    fn faults_are_named() {
        let said = |text: &str| read(text.as_bytes()).err().unwrap()[0].to_string();
        assert!(said("cut\n0 1 5 0 3 2 2\n").contains("line 2: '0 1 5 0 3 2 2': ICUT 1"));
        assert!(said("cut\n0 1 5 0 2 1 2\n").contains("ICOMP 1 or 3"));
        assert!(said("cut\n0 1 3 0 3 1 2\n1 0 0 0\n").contains("the last cut has 1 lines of 3"));
        assert!(said("").contains("no cut"));
        assert!(said("cut\n-1 1 5 0 3 1 2\n").contains("as far below 0"));
        let quarter: String = file(0.0, 3).split("Field").take(31).collect::<Vec<_>>().join("Field");
        assert!(said(&quarter).contains("no cut within"), "{}", said(&quarter));
        assert!(said(&file(0.0, 3).replacen("D", "X", 1)).contains("line 3"));
    }
}
