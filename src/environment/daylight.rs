//! A day: a CIE sky, its sun and the ground, as bright as they are outdoors or as asked for.

use std::f64::consts::PI;

use glam::DVec3;

use super::sun::sun_through_air;
use super::{Dome, Environment, Sky, SkyKind, Sun, toward};
use crate::error::{Error, Result};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// What is said of a day.
#[derive(Debug, Clone)]
pub struct Daylight {
    /// Which distribution of luminance the sky has.
    pub kind: SkyKind,
    /// Where the sun is; `None` leaves its light out.
    pub sun: Option<SunPlace>,
    /// Luminous turbidity of the air: 1 is clean, 2 to 3 clear, 5 hazy.
    pub turbidity: f64,
    /// Correlated color temperature of the sky; by its kind if not given.
    pub cct_k: Option<f64>,
    /// Reflectance of an even ground, 0 to 1.
    pub ground: Spectrum,
    /// lx of sky and sun together on a level plane; by kind and elevation if not given.
    pub illuminance_lx: Option<f64>,
}

/// Where the sun stands.
#[derive(Debug, Clone)]
pub struct SunPlace {
    /// Turned about +Y from +Z toward +X, degrees.
    pub azimuth_deg: f64,
    /// 0 to 90.
    pub elevation_deg: f64,
    /// lx facing it; 0 leaves the disc out. By turbidity if not given.
    pub illuminance_lx: Option<f64>,
    /// Color temperature of CIE daylight, K; its spectrum follows from the air if not given.
    pub cct_k: Option<f64>,
}

const OBJECT: &str = "environment.sky";

impl Daylight {
    /// Errors: a sky that needs a sun without one; a sun brighter than all that is asked for.
    pub fn environment(&self) -> Result<Environment> {
        if self.kind.needs_sun() && self.sun.is_none() {
            return Err(Error::MissingKey {
                object: OBJECT.to_owned(),
                key: "sun".to_owned(),
                expected: "expected where the sun stands: this sky's luminance depends on it"
                    .to_owned(),
            });
        }
        let sun = self.sun.as_ref().map(|place| self.sun_at(place));
        let [sky_lx, sun_factor] = self.shares(sun.as_ref())?;
        let sun = sun.map(|sun| Sun { illuminance_lx: sun.illuminance_lx * sun_factor, ..sun });
        let environment = self.with_ground(sky_lx, sun.as_ref())?;
        let is_bright = |sun: &Sun| sun.illuminance_lx > 0.0;
        Ok(match sun.filter(is_bright) {
            Some(sun) => environment.with_sun(sun),
            None => environment,
        })
    }

    fn sun_at(&self, place: &SunPlace) -> Sun {
        let (through_air, spectrum) = sun_through_air(place.elevation_deg, self.turbidity);
        let usual = if self.kind.hides_sun() { 0.0 } else { through_air };
        Sun {
            direction: toward(place.azimuth_deg, place.elevation_deg),
            illuminance_lx: place.illuminance_lx.unwrap_or(usual),
            spectrum: place.cct_k.map_or(spectrum, Spectrum::daylight),
        }
    }

    /// The sky's lx on a level plane, and by how much the sun is to be scaled.
    fn shares(&self, sun: Option<&Sun>) -> Result<[f64; 2]> {
        let usual = self.usual_sky_lx();
        let Some(asked) = self.illuminance_lx else { return Ok([usual, 1.0]) };
        let of_sun = sun.map_or(0.0, Sun::level_illuminance_lx);
        let is_given = self.sun.as_ref().is_some_and(|place| place.illuminance_lx.is_some());
        if !is_given {
            let factor = asked / (usual + of_sun);
            return Ok([usual * factor, factor]);
        }
        if of_sun < asked {
            return Ok([asked - of_sun, 1.0]);
        }
        let problem = format!(
            "\"illuminance\" is {asked} lx on a level plane, of which the sun alone gives {of_sun:.0}"
        );
        Err(Error::inconsistent(OBJECT, problem))
    }

    /// lx of the sky alone on a level plane, A + B sinᶜ γ for the sun's elevation γ.
    ///
    /// Source: IES RP-21 (1984): cloudy, partly cloudy and clear skies. 10,000 lx without a sun.
    fn usual_sky_lx(&self) -> f64 {
        let Some(sun) = &self.sun else { return 10_000.0 };
        let [a, b, c] = match self.kind {
            SkyKind::Overcast => [300.0, 21_000.0, 1.0],
            SkyKind::Standard(sky) if sky.number <= 5 => [300.0, 21_000.0, 1.0],
            SkyKind::Standard(sky) if sky.number <= 10 => [300.0, 45_000.0, 1.0],
            SkyKind::Standard(_) => [800.0, 15_500.0, 0.5],
        };
        a + b * sun.elevation_deg.to_radians().sin().max(0.0).powf(c)
    }

    /// 6500 K under clouds, more the bluer the sky.
    fn usual_cct_k(&self) -> f64 {
        match self.kind {
            SkyKind::Overcast => 6500.0,
            SkyKind::Standard(sky) if sky.number <= 6 => 6500.0,
            SkyKind::Standard(sky) if sky.number <= 10 => 8000.0,
            SkyKind::Standard(_) => 12_000.0,
        }
    }

    fn with_ground(&self, sky_lx: f64, sun: Option<&Sun>) -> Result<Environment> {
        let direction = sun.map_or(DVec3::Y, |sun| sun.direction);
        let spectrum = Spectrum::daylight(self.cct_k.unwrap_or_else(|| self.usual_cct_k()));
        let even = Sky::new(self.kind, direction)?;
        let unit = Environment::new(Dome::Sky(even.clone()), vec![spectrum.clone()])?;
        let zenith = sky_lx / unit.illuminance_lx(DVec3::Y);
        if self.ground.max() <= 0.0 {
            return Ok(unit.scaled(zenith));
        }
        let luminous = |s: &Spectrum| s.luminous_flux(WavelengthGrid::Step5);
        let lit = |light: &Spectrum, lx: f64| light.scaled(lx / luminous(light));
        let mut arriving = lit(&spectrum, sky_lx);
        if let Some(sun) = sun {
            arriving = arriving.sum(&lit(&sun.spectrum, sun.level_illuminance_lx()));
        }
        let returned = arriving.product(&self.ground);
        let ground = luminous(&returned) / PI;
        let sky = Sky { zenith, ground, ..even };
        Environment::new(Dome::Sky(sky), vec![spectrum, returned])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clear(elevation_deg: f64) -> Daylight {
        Daylight {
            kind: SkyKind::standard(12).unwrap(),
            sun: Some(SunPlace {
                azimuth_deg: 0.0,
                elevation_deg,
                illuminance_lx: None,
                cct_k: None,
            }),
            turbidity: 2.5,
            cct_k: None,
            ground: Spectrum::constant(0.0),
            illuminance_lx: None,
        }
    }

    fn level(environment: &Environment) -> [f64; 2] {
        let sun = environment.sun().map_or(0.0, Sun::level_illuminance_lx);
        [environment.illuminance_lx(DVec3::Y), sun]
    }

    #[test]
    fn a_day_is_as_bright_as_asked() {
        let usual = level(&clear(45.0).environment().unwrap());
        assert!((usual[0] / (800.0 + 15_500.0 * 0.5f64.powf(0.25)) - 1.0).abs() < 1e-3);
        let asked = Daylight { illuminance_lx: Some(30_000.0), ..clear(45.0) };
        let [sky, sun] = level(&asked.environment().unwrap());
        assert!(((sky + sun) / 30_000.0 - 1.0).abs() < 1e-4);
        assert!((sun / sky / (usual[1] / usual[0]) - 1.0).abs() < 1e-3, "in the same proportion");
    }

    #[test]
    fn a_given_sun_stays() {
        let mut day = Daylight { illuminance_lx: Some(30_000.0), ..clear(30.0) };
        day.sun.as_mut().unwrap().illuminance_lx = Some(20_000.0);
        let [sky, sun] = level(&day.environment().unwrap());
        assert!((sun / 10_000.0 - 1.0).abs() < 1e-9 && (sky / 20_000.0 - 1.0).abs() < 1e-4);
        day.sun.as_mut().unwrap().illuminance_lx = Some(80_000.0);
        assert_eq!(
            day.environment().unwrap_err().to_string(),
            "environment.sky: \"illuminance\" is 30000 lx on a level plane, of which the sun alone \
             gives 40000"
        );
        day.sun.as_mut().unwrap().illuminance_lx = Some(0.0);
        assert!(day.environment().unwrap().sun().is_none());
    }

    /// A white ground under an even sky of 1 is a furnace: L = E/π above and below.
    #[test]
    fn a_white_ground_returns_what_it_gets() {
        let day = Daylight {
            kind: SkyKind::standard(5).unwrap(),
            sun: None,
            ground: Spectrum::constant(1.0),
            illuminance_lx: Some(PI),
            ..clear(0.0)
        };
        let environment = day.environment().unwrap();
        let (above, _) = environment.seen(toward(10.0, 20.0));
        let (below, _) = environment.seen(toward(10.0, -20.0));
        assert!((above[0] - 1.0).abs() < 1e-4 && (below[1] - 1.0).abs() < 1e-4);
        assert!((environment.illuminance_lx(toward(30.0, -40.0)) / PI - 1.0).abs() < 2e-4);
    }

    #[test]
    fn a_sky_that_needs_its_sun_asks_for_it() {
        let day = Daylight { sun: None, ..clear(0.0) };
        assert!(day.environment().unwrap_err().to_string().contains("\"sun\""));
    }
}
