//! CIELAB.

use super::Xyz;

/// CIE 1976 L*, a*, b* relative to some white.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Lab {
    /// L*, lightness: 0 is black, 100 is the white.
    pub l: f64,
    /// a*, toward red; negative toward green.
    pub a: f64,
    /// b*, toward yellow; negative toward blue.
    pub b: f64,
}

/// (6/29)³, below which the cube root of CIELAB becomes a line.
const LINEAR_BELOW: f64 = 216.0 / 24389.0;
/// Slope of that line, (29/6)²/3.
const SLOPE: f64 = 841.0 / 108.0;

fn lab_f(t: f64) -> f64 {
    if t > LINEAR_BELOW { t.cbrt() } else { SLOPE * t + 4.0 / 29.0 }
}

fn lab_f_inverse(f: f64) -> f64 {
    if f > 6.0 / 29.0 { f * f * f } else { (f - 4.0 / 29.0) / SLOPE }
}

impl Lab {
    /// Source: CIE 15:2004, 8.2.1.
    pub fn from_xyz(color: Xyz, white: Xyz) -> Self {
        let [fx, fy, fz] = [color.x / white.x, color.y / white.y, color.z / white.z].map(lab_f);
        Self { l: 116.0 * fy - 16.0, a: 500.0 * (fx - fy), b: 200.0 * (fy - fz) }
    }

    /// The color itself, in the unit of `white`. Source: CIE 15:2004, 8.2.1, inverted.
    pub fn to_xyz(self, white: Xyz) -> Xyz {
        let fy = (self.l + 16.0) / 116.0;
        let [x, y, z] = [fy + self.a / 500.0, fy, fy - self.b / 200.0].map(lab_f_inverse);
        Xyz::new(x * white.x, y * white.y, z * white.z)
    }

    /// C*ab.
    pub fn chroma(self) -> f64 {
        self.a.hypot(self.b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Xyz = Xyz::new(95.047, 100.0, 108.883);

    #[test]
    fn white_and_black() {
        assert_eq!(Lab::from_xyz(WHITE, WHITE), Lab { l: 100.0, a: 0.0, b: 0.0 });
        assert!(Lab::from_xyz(Xyz::default(), WHITE).l.abs() < 1e-13);
    }

    #[test]
    fn gray_of_18_4_percent_is_50() {
        // L* = 116 Y^(1/3) - 16 by hand: Y = (66/116)³.
        let gray = WHITE * (66.0f64 / 116.0).powi(3);
        assert!((Lab::from_xyz(gray, WHITE).l - 50.0).abs() < 1e-12);
    }

    #[test]
    fn xyz_and_back_on_both_sides_of_the_line() {
        for color in [Xyz::new(0.1, 0.2, 0.05), Xyz::new(41.0, 21.0, 2.0), WHITE * 30.0] {
            let back = Lab::from_xyz(color, WHITE).to_xyz(WHITE);
            let error = (back - color).x.abs() + (back - color).y.abs() + (back - color).z.abs();
            assert!(error < 1e-12 * (1.0 + color.y), "{color:?}: {error}");
        }
    }
}
