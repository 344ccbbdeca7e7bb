//! I_local: the sum over light samples and the ambient term (eq. 2, 9).

use super::layers::Origin;
use super::walk::{Branch, Facing, SurfacePoint};
use super::{LayeredSum, TraceState, Tracer};
use crate::light::sum::{HitQuery, LightSum, Visibility};
use crate::light::tree::LightTree;
use crate::scene::MaterialTables;
use crate::spectrum::Bands;

impl Tracer<'_> {
    pub(super) fn add_local(
        &self,
        surface: &SurfacePoint,
        branch: &Branch,
        state: &mut TraceState,
        sum: &mut LayeredSum,
    ) {
        let throughput = &branch.throughput;
        let scene = &self.prepared.scene;
        let material = &scene.materials[surface.material.0];
        let tables = &self.tables.materials[surface.material.0];
        if self.tables.has_ambient && material.k_a > 0.0 {
            sum.add(Origin::Surroundings, branch.kind, |sum| {
                self.add_ambient(material.k_a, tables, throughput, sum);
            });
        }
        if !self.is_lit(surface) {
            return;
        }
        let shares = self.mirrored_share(surface).map(|share| returned(tables, &share));
        let [f_r, f_t] = match &shares {
            Some([f_r, f_t]) => [f_r, f_t],
            None => [&tables.reflectance, &tables.transmittance],
        };
        for light in 0..scene.lights.len() {
            let from = (surface, &branch.media);
            let shadow_rays = self.each_light_sum(light, from, |answer, left| {
                state.counts.light_sums += 1;
                state.counts.light_nodes += u64::from(answer.nodes);
                state.counts.light_samples += u64::from(answer.samples);
                let power = &self.tables.lights[light];
                let dimmed = left.map(|left| product(throughput, left));
                let throughput = dimmed.as_ref().unwrap_or(throughput);
                sum.add(Origin::of_light(self.prepared, light), branch.kind, |sum| {
                    add_light(&answer, power, [f_r, f_t], throughput, sum);
                });
                if answer.reflected_error + answer.transmitted_error > 0.0 {
                    state.luminance_error +=
                        self.luminance_error(&answer, power, [f_r, f_t], throughput);
                }
            });
            state.counts.shadow_rays += shadow_rays;
        }
        if self.tables.surroundings.is_some() {
            // Counted once, added to the whole and to a layer.
            let mut returned = Bands::zero(self.tables.bands);
            self.add_surroundings(surface, [f_r, f_t], throughput, state, &mut returned);
            sum.add(Origin::Surroundings, branch.kind, |sum| sum.add(&returned));
        }
    }

    /// Whether any lobe on any side can return light to V.
    pub(super) fn is_lit(&self, surface: &SurfacePoint) -> bool {
        let query = self.hit_query(surface);
        query.reflects || query.transmits
    }

    pub(super) fn hit_query(&self, surface: &SurfacePoint) -> HitQuery<'_> {
        let scene = &self.prepared.scene;
        let tables = &self.tables.materials[surface.material.0];
        HitQuery {
            point: surface.near.departure.point,
            normal: surface.normal,
            view: surface.view,
            lobes: &scene.materials[surface.material.0].lobes,
            photometry: scene.photometry,
            reflects: tables.reflects,
            transmits: tables.transmits && surface.facing == Facing::Front,
        }
    }

    /// The sum on both sides, with lobes of its own on the far side where the scene asks for them.
    pub(super) fn both_sides(
        &self,
        tree: &LightTree,
        query: &HitQuery,
        (light_error, visible): (f64, Option<Visibility>),
        surface: &SurfacePoint,
    ) -> LightSum {
        let far = self.prepared.far_lobes(surface.material).filter(|_| query.transmits);
        let Some(lobes) = far else { return tree.sum(query, light_error, visible) };
        let near = HitQuery { transmits: false, ..*query };
        let far = HitQuery { reflects: false, lobes, ..*query };
        tree.sum(&near, light_error, visible).plus(&tree.sum(&far, light_error, visible))
    }

    /// k_a I_a(λ) F_r(λ), on both sides.
    fn add_ambient(&self, k_a: f64, tables: &MaterialTables, throughput: &Bands, sum: &mut Bands) {
        let mut weight = throughput.clone();
        weight.scale_by(k_a, &tables.reflectance);
        sum.add_product(&weight, &self.tables.ambient);
    }

    /// Y of the estimated errors, as it reaches the camera.
    fn luminance_error(
        &self,
        answer: &LightSum,
        power: &Bands,
        shares: [&Bands; 2],
        throughput: &Bands,
    ) -> f64 {
        let mut error = Bands::zero(self.tables.bands);
        let bounds = LightSum {
            reflected: answer.reflected_error,
            transmitted: answer.transmitted_error,
            ..LightSum::default()
        };
        add_light(&bounds, power, shares, throughput, &mut error);
        error.dot(&self.tables.luminance_weights)
    }
}

/// F_r R and F_t (1 − R): what lobes return under Fresnel's law.
fn returned(tables: &MaterialTables, share: &Bands) -> [Bands; 2] {
    let mut passed = Bands::one(share.as_slice().len());
    passed.as_mut_slice().iter_mut().zip(share.as_slice()).for_each(|(one, r)| *one -= r);
    [product(&tables.reflectance, share), product(&tables.transmittance, &passed)]
}

fn product(a: &Bands, b: &Bands) -> Bands {
    let mut product = a.clone();
    product.scale_by(1.0, b);
    product
}

/// I_i(λ) Σ …: the scalar sums times spectra; `f_r` and `f_t` are what the two sides return.
fn add_light(
    answer: &LightSum,
    power: &Bands,
    [f_r, f_t]: [&Bands; 2],
    throughput: &Bands,
    sum: &mut Bands,
) {
    let sum = sum.as_mut_slice();
    let (power, throughput) = (power.as_slice(), throughput.as_slice());
    let (f_r, f_t) = (f_r.as_slice(), f_t.as_slice());
    for band in 0..sum.len() {
        let returned = f_r[band] * answer.reflected + f_t[band] * answer.transmitted;
        sum[band] += throughput[band] * power[band] * returned;
    }
}
