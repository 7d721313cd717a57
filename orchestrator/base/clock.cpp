#include "base/clock.hpp"

#include <cmath>
#include <cstdio>
#include <ctime>

namespace sandglass {

double SystemClock::now() const {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

namespace {

std::string whole_seconds(std::time_t moment) {
  std::tm parts{};
  gmtime_r(&moment, &parts);
  char text[64];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
  return text;
}

}  // namespace

std::string date_and_time() { return whole_seconds(std::time(nullptr)) + "Z"; }

double seconds_since_1970() {
  timespec time{};
  clock_gettime(CLOCK_REALTIME, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string date_and_time(double seconds_since_1970) {
  const double whole = std::floor(seconds_since_1970);
  char fraction[32];
  std::snprintf(fraction, sizeof fraction, ".%06d",
                static_cast<int>(1e6 * (seconds_since_1970 - whole)));
  return whole_seconds(static_cast<std::time_t>(whole)) + fraction + "+00:00";
}

}  // namespace sandglass
