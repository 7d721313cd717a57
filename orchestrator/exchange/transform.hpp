#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sandglass::exchange {

/// What happens to a field in transit. The first axis of a field holds its samples (over time
/// within a window, or over entities); statistics reduce it, `linear` resamples it.
enum class Transform {
  identity,
  mean,
  median,
  minimum,
  maximum,
  sum,
  linear  ///< m samples, equally spaced with the last at the window's end, to n of the same kind
};

/// The shape of the result. `samples` is n for Transform::linear.
std::vector<std::int64_t> transformed_shape(Transform transform, std::vector<std::int64_t> shape,
                                            std::int64_t samples);

/// Applies the transform to `values` of this shape (row-major). Reducing zero rows gives NaN for
/// every statistic but the sum, which is 0. For `linear`, sample i of m stands at the time
/// (i+1)/m of the window; before the first sample the value is constant.
std::vector<double> apply(Transform transform, std::span<const double> values,
                          const std::vector<std::int64_t>& shape, std::int64_t samples);

}  // namespace sandglass::exchange
