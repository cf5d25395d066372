// Sites differ. `kind` has a byte for each, four to an element, which says where in `kind_factor` its
// factor of the stencil is. Sites of kind 0 have no particle, or a row of their own.

fn site_sum(site: u32, own: Value) -> real {
    let of_site = (kind[site / 4u] >> (8u * (site % 4u))) & 255u;
    if of_site == 0u {
        return real(0.0);
    }
    return times(kind_factor[of_site], stencil_sum(site, own));
}

