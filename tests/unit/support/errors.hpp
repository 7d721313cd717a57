#pragma once

#include <gtest/gtest.h>

#include <string>

#include "base/error.hpp"

namespace sandglass::test {

/// The Error that `act` throws; a failed test when it throws none.
template <typename Act>
Error error_of(Act act) {
  try {
    act();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no Error was thrown";
  return Error::usage("no Error was thrown");
}

inline std::string remedy_of(const Error& error) { return error.problems().at(0).remedy; }

}  // namespace sandglass::test
