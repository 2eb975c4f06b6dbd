#pragma once

#include <span>

#include "bench/real/real_set.hpp"

namespace multireach::bench {

/// Prints, for each object of stereo pairs with true disparities, how far the measured depth is from the true ones.
/// Then, where `random_clicks` is not 0, what is answered after so many clicks at random on each. `refused`: also with
/// colours that `calibrate colour` refuses.
void print_still(std::span<const RealSet> pairs, int random_clicks, bool refused);

/// Prints how far objects are from positions that were measured by other means: as vision locates them, and as clicks
/// by hand do, triangulated. `refused`: also with colours that `calibrate colour` refuses; `each`: a line for each
/// object.
void print_measured(std::span<const RealSet> pairs, bool refused, bool each);

}  // namespace multireach::bench
