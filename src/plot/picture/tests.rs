//! What is where on a picture.

use proptest::prelude::*;

use super::*;

/// Pixels of a colour, and the smallest area around them.
fn found(canvas: &Canvas, colour: Colour) -> (usize, Area) {
    let mut area = [i64::MAX, i64::MAX, i64::MIN, i64::MIN];
    let mut count = 0;
    for y in 0..canvas.height() as i64 {
        for x in 0..canvas.width() as i64 {
            if canvas.pixel(x, y) == Some(colour) {
                count += 1;
                area = [area[0].min(x), area[1].min(y), area[2].max(x + 1), area[3].max(y + 1)];
            }
        }
    }
    (count, area)
}

fn metres(label: &str, to: f64) -> Axis<'_> {
    Axis { label, from: 0.0, to }
}

#[test]
fn y_is_upward_and_cells_keep_their_shape() {
    // The cell at the lower right is the highest.
    let values = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    let picture = Picture {
        limits: Limits::Fixed([0.0, 1.0]),
        x: metres("East, m", 30.0),
        y: metres("North, m", 20.0),
        ..Picture::new(&values, [3, 2]).unwrap()
    };
    let canvas = picture.draw().unwrap();
    let sheet = Drawing::new(&picture, picture.size(), [0.0, 1.0], &[0.0]);
    let [left, top, right, bottom] = sheet.map;
    // 640 / 3 = 213 whole pixels a cell.
    assert_eq!((right - left, bottom - top), (639, 426));
    let (high, low) = (ColourMap::Deep.colour(1.0), ColourMap::Deep.colour(0.0));
    assert_eq!(canvas.pixel(right - 1, bottom - 1), Some(high));
    assert_eq!(canvas.pixel(right - 213, bottom - 213), Some(high));
    assert_eq!(canvas.pixel(right - 214, bottom - 213), Some(low));
    assert_eq!(canvas.pixel(right - 213, bottom - 214), Some(low));
    assert_eq!(canvas.pixel(left, top), Some(low));
}

#[test]
fn the_scale_bar_has_its_length() {
    let values = [0.5; 200 * 100];
    let picture = Picture {
        x: metres("East, m", 400.0),
        y: metres("North, m", 200.0),
        scale_bar: Some("m"),
        ..Picture::new(&values, [200, 100]).unwrap()
    };
    let canvas = picture.draw().unwrap();
    let sheet = Drawing::new(&picture, picture.size(), [0.0, 1.0], &[0.5]);
    let (key, _) = sheet.key(&picture, 0);
    // 100 m of 400 m, on 600 pixels.
    assert_eq!((key[0].width, key[0].text.as_str()), (150, "100 m"));
    // It is drawn: the only run of ink that long apart from the frames.
    let runs = (0..canvas.height() as i64)
        .filter(|y| {
            let dark = |x| canvas.pixel(x, *y) == Some(INK);
            (0..150).all(|i| dark(sheet.map[0] + i)) && !dark(sheet.map[0] + 150) && !dark(sheet.map[0] - 1)
        })
        .count();
    assert_eq!(runs, 5);
    assert_eq!(
        (measure(2000.0, "m"), measure(0.5, "m"), measure(1e7, "s")),
        ("2 km".into(), "0.5 m".into(), "1e7 s".into())
    );
}

#[test]
fn masked_pixels_are_grey_and_explained() {
    let mut values = vec![1.0; 64];
    let with = |values: &[f64]| {
        let picture = Picture { masked: "in shadow", ..Picture::new(values, [8, 8]).unwrap() };
        picture.draw().unwrap()
    };
    assert_eq!(found(&with(&values), MASKED).0, 0);
    values[8 * 7] = f64::NAN;
    let canvas = with(&values);
    let (count, area) = found(&canvas, MASKED);
    // One cell of 80 x 80 pixels at the upper left, and the mark below the map of 14 x 14.
    assert_eq!(count, 80 * 80 + 14 * 14);
    assert!(area[3] > area[1] + 640);
}

#[test]
fn values_beyond_the_limits_show_on_the_colour_bar() {
    let values: Vec<f64> = (0..100).map(f64::from).collect();
    let reach = |limits| {
        let picture = Picture { limits, ..Picture::new(&values, [10, 10]).unwrap() };
        let canvas = picture.draw().unwrap();
        let bar = Drawing::new(&picture, picture.size(), [0.0, 1.0], &[0.0]).bar;
        let middle = (bar[0] + bar[2]) / 2;
        [canvas.pixel(middle, bar[1] - 4), canvas.pixel(middle, bar[3] + 3)]
    };
    assert_eq!(reach(Limits::Percentile(100.0)), [Some(WHITE); 2]);
    let ends = [1.0, 0.0].map(|share| Some(ColourMap::Deep.colour(share)));
    assert_eq!(reach(Limits::Percentile(50.0)), ends);
    assert_eq!(reach(Limits::Fixed([-5.0, 50.0])), [ends[0], Some(WHITE)]);
}

#[test]
fn zero_is_the_middle_of_a_diverging_map() {
    let values = [-1.0, 0.0, 4.0, f64::NAN];
    let picture = Picture { colours: ColourMap::Swell, ..Picture::new(&values, [4, 1]).unwrap() };
    let canvas = picture.draw().unwrap();
    let [left, _, _, bottom] = Drawing::new(&picture, picture.size(), [0.0, 1.0], &[0.0]).map;
    // 128 of 255 steps.
    assert_eq!(canvas.pixel(left + 200, bottom - 1), Some(ColourMap::Swell.colour(128.0 / 255.0)));
}

#[test]
fn what_cannot_be_drawn_is_reported() {
    let values = [0.0; 6];
    assert!(matches!(
        Picture::new(&values, [4, 2]),
        Err(PictureError::Shape { values: 6, columns: 4, rows: 2 })
    ));
    assert!(Picture::new(&[], [0, 5]).is_err() && Picture::new(&values, [usize::MAX, 3]).is_err());
    let good = Picture::new(&values, [3, 2]).unwrap();
    for (from, to) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (1e9, 1e9 + 1e-6)] {
        let axis = Axis { label: "", from, to };
        assert!(Picture { x: axis, ..good }.draw().is_err() && Picture { y: axis, ..good }.draw().is_err());
    }
    assert!(Picture { limits: Limits::Percentile(101.0), ..good }.draw().is_err());
}

fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => any::<f64>(),
        4 => -10.0..10.0f64,
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(f64::NEG_INFINITY),
        1 => Just(0.0),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn any_array_is_drawn(
        values in prop_oneof![
            prop::collection::vec(value(), 1..300),
            value().prop_flat_map(|v| prop::collection::vec(Just(v), 1..50)),
        ],
        columns in 1usize..300,
        label in ".{0,200}",
        sides in [any::<f64>(), any::<f64>(), any::<f64>(), any::<f64>()],
        which in 0usize..3,
        equal_aspect: bool,
        size_px in 0usize..200,
    ) {
        let columns = columns.min(values.len());
        let rows = values.len() / columns;
        let plain = Picture::new(&values[..rows * columns], [columns, rows]).unwrap();
        let picture = Picture {
            title: &label,
            x: Axis { label: &label, from: sides[0].min(sides[1]), to: sides[0].max(sides[1]) },
            y: Axis { label: &label, from: sides[2].min(sides[3]), to: sides[2].max(sides[3]) },
            quantity: &label,
            masked: &label,
            scale_bar: Some("m"),
            colours: [ColourMap::Deep, ColourMap::Swell, ColourMap::Deep][which],
            limits: [Limits::Percentile(98.0), Limits::Percentile(100.0), Limits::Below { percent: 99.0, span: 30.0 }][which],
            reduction: [Reduction::Mean, Reduction::Nearest, Reduction::MeanPower][which],
            equal_aspect,
            size_px,
            ..plain
        };
        for picture in [picture, Picture { x: plain.x, y: plain.y, ..picture }] {
            match picture.draw() {
                Ok(canvas) => prop_assert!(canvas.width() < 4000 && canvas.height() < 4000),
                Err(error) => prop_assert!(matches!(error, PictureError::Axis { .. }), "{error}"),
            }
        }
    }
}
