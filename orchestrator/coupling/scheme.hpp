#pragma once

namespace sandglass::coupling {

/// In which order, and with which values, participants run within a window.
enum class Scheme {
  serial_explicit,    ///< one after the other, each with the newest values (Gauss-Seidel)
  parallel_explicit,  ///< all at once, with the values of the window before (Jacobi)
  serial_implicit     ///< as serial_explicit, repeated until the relaxed fields no longer change
};

}  // namespace sandglass::coupling
