//! A room seen from its middle: a ceiling with luminous rectangles, walls and a floor.

use glam::DVec3;

use super::dome::Luminances;

/// A luminous rectangle in the ceiling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CeilingPanel {
    /// mm from the middle of the room: x, z.
    pub center: [f64; 2],
    /// mm along x and z.
    pub size: [f64; 2],
    /// cd/m².
    pub luminance: f64,
}

impl CeilingPanel {
    fn holds(&self, [x, z]: [f64; 2]) -> bool {
        let inside = |at: f64, center: f64, size: f64| (at - center).abs() <= 0.5 * size;
        inside(x, self.center[0], self.size[0]) && inside(z, self.center[1], self.size[1])
    }
}

/// Walls, ceiling and floor around the origin; only directions count, as with all surroundings.
///
/// Panels shine in the first spectrum, the rest in the second.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    /// mm along x and z.
    pub size: [f64; 2],
    /// Height of the ceiling over the lamp, mm.
    pub above_mm: f64,
    /// Depth of the floor under the lamp, mm.
    pub below_mm: f64,
    /// Luminous rectangles of the ceiling; the first that holds a point counts.
    pub panels: Vec<CeilingPanel>,
    /// cd/m².
    pub ceiling: f64,
    /// Luminance of the walls, cd/m².
    pub walls: f64,
    /// Luminance of the floor, cd/m².
    pub floor: f64,
}

impl Room {
    pub(super) fn luminances(&self, direction: DVec3) -> Luminances {
        // How far along the ray each pair of walls is; the nearest is seen.
        let far = |along: f64, half: f64| half / along.abs().max(1e-300);
        let level = if direction.y > 0.0 { self.above_mm } else { self.below_mm };
        let to_level = far(direction.y, level);
        let to_wall =
            far(direction.x, 0.5 * self.size[0]).min(far(direction.z, 0.5 * self.size[1]));
        if to_wall < to_level {
            return [0.0, self.walls, 0.0];
        }
        if direction.y <= 0.0 {
            return [0.0, self.floor, 0.0];
        }
        let place = [direction.x * to_level, direction.z * to_level];
        match self.panels.iter().find(|panel| panel.holds(place)) {
            Some(panel) => [panel.luminance, 0.0, 0.0],
            None => [0.0, self.ceiling, 0.0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::toward;

    #[test]
    fn each_part_is_where_it_is() {
        let panel =
            CeilingPanel { center: [1000.0, 0.0], size: [500.0, 2000.0], luminance: 5000.0 };
        let room = Room {
            size: [6000.0, 8000.0],
            above_mm: 2000.0,
            below_mm: 1000.0,
            panels: vec![panel],
            ceiling: 100.0,
            walls: 50.0,
            floor: 20.0,
        };
        let toward_point = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).normalize();
        let seen = |direction| room.luminances(direction);
        assert_eq!(seen(toward_point(1240.0, 2000.0, 990.0)), [5000.0, 0.0, 0.0]);
        assert_eq!(seen(toward_point(1260.0, 2000.0, 0.0)), [0.0, 100.0, 0.0]);
        assert_eq!(seen(toward_point(3000.0, 1990.0, 0.0)), [0.0, 50.0, 0.0]);
        assert_eq!(seen(toward_point(3000.0, 2010.0, 0.0)), [0.0, 100.0, 0.0]);
        assert_eq!(seen(toward(0.0, -15.0)), [0.0, 20.0, 0.0]);
        assert_eq!(seen(toward(0.0, -14.0)), [0.0, 50.0, 0.0]);
    }
}
