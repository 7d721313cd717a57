#pragma once

namespace sandglass::freefem {

/// Adds the functions of the material point method (mpm...) to FreeFEM.
void add_material_points();

}  // namespace sandglass::freefem
