//! The colors of signal lamps: red, amber and white of UN R48, par. 2.29.

/// Colors of light emitted, by their boundaries in CIE 1931 (x, y).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignalColor {
    /// Red, as of stop and tail lamps.
    Red,
    /// Amber, as of direction indicators.
    Amber,
    /// White, as of reversing lamps.
    White,
}

impl SignalColor {
    /// Every color, in the order of the regulation.
    pub const ALL: [Self; 3] = [Self::Red, Self::Amber, Self::White];

    /// The word that scripts and data files use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Red => "red",
            Self::Amber => "amber",
            Self::White => "white",
        }
    }

    /// Whether the chromaticity lies on this color's side of all its boundary lines.
    ///
    /// The spectral locus and the purple line bound the rest: no light lies beyond them.
    pub fn contains(self, [x, y]: [f64; 2]) -> bool {
        match self {
            Self::Red => y <= 0.335 && y >= 0.980 - x,
            Self::Amber => y <= x - 0.120 && y >= 0.390 && y >= 0.790 - 0.670 * x,
            Self::White => {
                // The purple line ends where it meets y = 0.382.
                (0.310..=0.500).contains(&x)
                    && y <= (0.150 + 0.640 * x).min(0.440)
                    && y >= (0.050 + 0.750 * x).min(0.382)
            }
        }
    }

    /// The corners that the regulation prints, in order around the area.
    pub fn corners(self) -> &'static [[f64; 2]] {
        match self {
            Self::Red => &[[0.645, 0.335], [0.665, 0.335], [0.735, 0.265], [0.721, 0.259]],
            Self::Amber => &[[0.545, 0.425], [0.560, 0.440], [0.609, 0.390], [0.597, 0.390]],
            Self::White => &[
                [0.310, 0.348],
                [0.453, 0.440],
                [0.500, 0.440],
                [0.500, 0.382],
                [0.443, 0.382],
                [0.310, 0.283],
            ],
        }
    }
}

/// The color whose area holds the chromaticity.
pub fn color_of(xy: [f64; 2]) -> Option<SignalColor> {
    SignalColor::ALL.into_iter().find(|color| color.contains(xy))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners are the meeting points of the lines, rounded to three places: a step of 0.002
    /// toward the area's middle lies inside, one away from it outside.
    #[test]
    fn corners_bound_the_areas() {
        for color in SignalColor::ALL {
            let corners = color.corners();
            // A point that sees all corners.
            let middle = match color {
                SignalColor::Red => [0.69, 0.30],
                SignalColor::Amber => [0.577, 0.412],
                SignalColor::White => [0.46, 0.40],
            };
            assert_eq!(color_of(middle), Some(color));
            for corner in corners {
                let step = |sign: f64| {
                    let [dx, dy] = [middle[0] - corner[0], middle[1] - corner[1]];
                    let scale = sign * 0.002 / dx.hypot(dy);
                    [corner[0] + scale * dx, corner[1] + scale * dy]
                };
                assert!(color.contains(step(1.0)), "{color:?} {corner:?}");
                // Beyond the spectral locus there are no lines and no light.
                let on_locus = match color {
                    SignalColor::Red => corner[0] > 0.7,
                    SignalColor::Amber => corner[0] + corner[1] > 0.9989,
                    SignalColor::White => false,
                };
                assert!(on_locus || !color.contains(step(-1.0)), "{color:?} {corner:?}");
            }
        }
    }

    #[test]
    fn colors_of_known_lights() {
        // CIE illuminant A, and the edges of the spectrum.
        assert_eq!(color_of([0.44757, 0.40745]), Some(SignalColor::White));
        assert_eq!(color_of([0.7347, 0.2653]), Some(SignalColor::Red));
        assert_eq!(color_of([0.1, 0.8]), None);
        assert_eq!(color_of([0.5, 0.381]), None);
        assert_eq!(color_of([0.40, 0.36]), Some(SignalColor::White));
    }
}
