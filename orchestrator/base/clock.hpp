#pragma once

#include <string>

namespace sandglass {

/// Time as the engine sees it; tests replace it.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Seconds since an arbitrary origin, monotonic.
  [[nodiscard]] virtual double now() const = 0;
};

/// The machine's monotonic clock.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] double now() const override;
};

/// The date and time now, UTC, as "2026-11-22T14:03:33Z".
std::string date_and_time();

/// Seconds since the begin of 1970, UTC, by the machine's calendar.
double seconds_since_1970();
/// The same moment in words, "2026-11-22T14:03:33.250000+00:00".
std::string date_and_time(double seconds_since_1970);

}  // namespace sandglass
