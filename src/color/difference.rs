//! Color differences in CIELAB.

use super::Lab;

/// ΔE*ab: the distance in CIELAB. Source: CIE 15:2004, 8.2.1.3.
pub fn delta_e_ab(p: Lab, q: Lab) -> f64 {
    ((p.l - q.l).powi(2) + (p.a - q.a).powi(2) + (p.b - q.b).powi(2)).sqrt()
}

/// CIEDE2000 with k_L = k_C = k_H = 1.
///
/// Source: CIE 142-2001, in the steps of Sharma, Wu & Dalal, Color Research & Application 30(1),
/// 2005, whose equation numbers stand beside them.
pub fn delta_e_2000(p: Lab, q: Lab) -> f64 {
    let chroma_mean = 0.5 * (p.chroma() + q.chroma());
    let g = 0.5 * (1.0 - chroma_weight(chroma_mean)); // eq. 4
    let (p, q) = (Polar::from_lab(p, g), Polar::from_lab(q, g));
    let dl = q.l - p.l;
    let dc = q.chroma - p.chroma;
    let dh = 2.0 * (p.chroma * q.chroma).sqrt() * (0.5 * hue_difference(p, q)).sin(); // eq. 11

    let l = 0.5 * (p.l + q.l);
    let c = 0.5 * (p.chroma + q.chroma);
    let h = hue_mean(p, q);
    let t = 1.0 - 0.17 * (h - radians(30.0)).cos()
        + 0.24 * (2.0 * h).cos()
        + 0.32 * (3.0 * h + radians(6.0)).cos()
        - 0.20 * (4.0 * h - radians(63.0)).cos(); // eq. 15
    let l_50 = (l - 50.0).powi(2);
    let s_l = 1.0 + 0.015 * l_50 / (20.0 + l_50).sqrt(); // eq. 18
    let s_c = 1.0 + 0.045 * c; // eq. 19
    let s_h = 1.0 + 0.015 * c * t; // eq. 20
    let turn = radians(30.0) * (-((h.to_degrees() - 275.0) / 25.0).powi(2)).exp(); // eq. 16
    let r_t = -(2.0 * turn).sin() * 2.0 * chroma_weight(c); // eq. 17, 21

    let (l, c, h) = (dl / s_l, dc / s_c, dh / s_h);
    (l * l + c * c + h * h + r_t * c * h).max(0.0).sqrt() // eq. 22
}

/// L′, C′, h′ (radians, 0 to 2π) of eq. 5 to 7.
#[derive(Clone, Copy)]
struct Polar {
    l: f64,
    chroma: f64,
    hue: f64,
}

impl Polar {
    fn from_lab(lab: Lab, g: f64) -> Self {
        let a = (1.0 + g) * lab.a;
        let hue = lab.b.atan2(a).rem_euclid(TURN);
        Self { l: lab.l, chroma: a.hypot(lab.b), hue }
    }
}

const TURN: f64 = 2.0 * std::f64::consts::PI;

fn radians(degrees: f64) -> f64 {
    degrees.to_radians()
}

/// √(C⁷ / (C⁷ + 25⁷)).
fn chroma_weight(chroma: f64) -> f64 {
    let c7 = chroma.powi(7);
    (c7 / (c7 + 25.0f64.powi(7))).sqrt()
}

/// Eq. 10: h′₂ − h′₁ the short way around; 0 if either is gray.
fn hue_difference(p: Polar, q: Polar) -> f64 {
    let d = q.hue - p.hue;
    if p.chroma * q.chroma == 0.0 {
        0.0
    } else if d > 0.5 * TURN {
        d - TURN
    } else if d < -0.5 * TURN {
        d + TURN
    } else {
        d
    }
}

/// Eq. 14: the hue between the two; of a gray and a color, the color's.
fn hue_mean(p: Polar, q: Polar) -> f64 {
    let sum = p.hue + q.hue;
    if p.chroma * q.chroma == 0.0 {
        sum
    } else if (p.hue - q.hue).abs() <= 0.5 * TURN {
        0.5 * sum
    } else if sum < TURN {
        0.5 * (sum + TURN)
    } else {
        0.5 * (sum - TURN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sharma, Wu & Dalal 2005, Table 1: L*, a*, b* twice, then ΔE00 to four decimals. All 34.
    #[rustfmt::skip]
    const PAIRS: [[f64; 7]; 34] = [
        [50.0000, 2.6772, -79.7751, 50.0000, 0.0000, -82.7485, 2.0425],
        [50.0000, 3.1571, -77.2803, 50.0000, 0.0000, -82.7485, 2.8615],
        [50.0000, 2.8361, -74.0200, 50.0000, 0.0000, -82.7485, 3.4412],
        [50.0000, -1.3802, -84.2814, 50.0000, 0.0000, -82.7485, 1.0000],
        [50.0000, -1.1848, -84.8006, 50.0000, 0.0000, -82.7485, 1.0000],
        [50.0000, -0.9009, -85.5211, 50.0000, 0.0000, -82.7485, 1.0000],
        [50.0000, 0.0000, 0.0000, 50.0000, -1.0000, 2.0000, 2.3669],
        [50.0000, -1.0000, 2.0000, 50.0000, 0.0000, 0.0000, 2.3669],
        [50.0000, 2.4900, -0.0010, 50.0000, -2.4900, 0.0009, 7.1792],
        [50.0000, 2.4900, -0.0010, 50.0000, -2.4900, 0.0010, 7.1792],
        [50.0000, 2.4900, -0.0010, 50.0000, -2.4900, 0.0011, 7.2195],
        [50.0000, 2.4900, -0.0010, 50.0000, -2.4900, 0.0012, 7.2195],
        [50.0000, -0.0010, 2.4900, 50.0000, 0.0009, -2.4900, 4.8045],
        [50.0000, -0.0010, 2.4900, 50.0000, 0.0010, -2.4900, 4.8045],
        [50.0000, -0.0010, 2.4900, 50.0000, 0.0011, -2.4900, 4.7461],
        [50.0000, 2.5000, 0.0000, 50.0000, 0.0000, -2.5000, 4.3065],
        [50.0000, 2.5000, 0.0000, 73.0000, 25.0000, -18.0000, 27.1492],
        [50.0000, 2.5000, 0.0000, 61.0000, -5.0000, 29.0000, 22.8977],
        [50.0000, 2.5000, 0.0000, 56.0000, -27.0000, -3.0000, 31.9030],
        [50.0000, 2.5000, 0.0000, 58.0000, 24.0000, 15.0000, 19.4535],
        [50.0000, 2.5000, 0.0000, 50.0000, 3.1736, 0.5854, 1.0000],
        [50.0000, 2.5000, 0.0000, 50.0000, 3.2972, 0.0000, 1.0000],
        [50.0000, 2.5000, 0.0000, 50.0000, 1.8634, 0.5757, 1.0000],
        [50.0000, 2.5000, 0.0000, 50.0000, 3.2592, 0.3350, 1.0000],
        [60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644],
        [63.0109, -31.0961, -5.8663, 62.8187, -29.7946, -4.0864, 1.2630],
        [61.2901, 3.7196, -5.3901, 61.4292, 2.2480, -4.9620, 1.8731],
        [35.0831, -44.1164, 3.7933, 35.0232, -40.0716, 1.5901, 1.8645],
        [22.7233, 20.0904, -46.6940, 23.0331, 14.9730, -42.5619, 2.0373],
        [36.4612, 47.8580, 18.3852, 36.2715, 50.5065, 21.2231, 1.4146],
        [90.8027, -2.0831, 1.4410, 91.1528, -1.6435, 0.0447, 1.4441],
        [90.9257, -0.5406, -0.9208, 88.6381, -0.8985, -0.7239, 1.5381],
        [6.7747, -0.2908, -2.4247, 5.8714, -0.0985, -2.2286, 0.6377],
        [2.0776, 0.0795, -1.1350, 0.9033, -0.0636, -0.5514, 0.9082],
    ];

    #[test]
    fn published_pairs_both_ways() {
        for [l1, a1, b1, l2, a2, b2, expected] in PAIRS {
            let p = Lab { l: l1, a: a1, b: b1 };
            let q = Lab { l: l2, a: a2, b: b2 };
            // Printed to four decimals.
            assert!((delta_e_2000(p, q) - expected).abs() < 5.1e-5, "{p:?} {q:?}");
            assert!((delta_e_2000(q, p) - expected).abs() < 5.1e-5, "{q:?} {p:?}");
        }
    }

    #[test]
    fn distance_in_lab() {
        let p = Lab { l: 50.0, a: 1.0, b: -2.0 };
        let q = Lab { l: 53.0, a: 5.0, b: 10.0 };
        assert_eq!(delta_e_ab(p, q), 13.0);
        assert_eq!(delta_e_ab(p, p), 0.0);
    }
}
