#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace sandglass::study {

/// One thing that two runs, or two studies, have not alike.
struct Difference {
  std::string what;
  std::string left;
  std::string right;
  std::string size;  ///< of the difference, where it has one: "relative 1.2e-05"
};

/// Two runs, or two studies, side by side.
struct Contrast {
  std::vector<Difference> inputs;      ///< parameters, templates, data, solvers, machine
  std::vector<Difference> quantities;  ///< results; of studies: per point the one that differs most
  std::vector<Difference> curves;      ///< the largest difference over the common abscissae
  std::size_t same_quantities = 0;
  std::size_t same_curves = 0;
};

/// Compares what lies in two run directories, or in two folders of studies (whose points are
/// matched by name). Throws Error::environment when one of them is neither, or they are not of a
/// kind.
Contrast contrast(const std::string& left, const std::string& right);

}  // namespace sandglass::study
