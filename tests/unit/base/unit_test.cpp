#include "base/unit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace sandglass {
namespace {

struct Written {
  const char* text;
  double si;
};

TEST(Quantity, IsReadAsPeopleWriteIt) {
  constexpr double degree = std::numbers::pi / 180;
  const Written all[] = {
      {"0.1 mm", 1e-4},
      {"0.1mm", 1e-4},
      {" 0.1", -1},
      {"23 cm", 0.23},
      {"17.19 deg", 17.19 * degree},
      {"17.19 degree", 17.19 * degree},
      {"17.19°", 17.19 * degree},
      {"1e-3 Pa s", 1e-3},
      {"1e-3 Pa.s", 1e-3},
      {"1e-3 Pa*s", 1e-3},
      {"1e-3 Pa·s", 1e-3},
      {"1 mPa s", 1e-3},
      {"1 kg/m/s", 1},
      {"2650 kg/m3", 2650},
      {"2650 kg/m^3", 2650},
      {"2650 kg/m**3", 2650},
      {"2650 kg/m³", 2650},
      {"2650 kg m-3", 2650},
      {"2650 kg.m-3", 2650},
      {"2650 kg m^-3", 2650},
      {"2.65 g/cm3", 2650},
      {"9.81 m/s2", 9.81},
      {"9.81 m/s^2", 9.81},
      {"9.81 m/s/s", 9.81},
      {"9.81 m s-2", 9.81},
      {"20 degC", 293.15},
      {"20 °C", 293.15},
      {"293 K", 293},
      {"5 %", 0.05},
      {"5%", 0.05},
      {"42", 42},
      {"+42", 42},
      {"-3e5 Pa", -3e5},
      {"1.e3", 1000},
      {".5 m", 0.5},
      {"2 1/s", 2},
      {"2 s-1", 2},
      {"2 Hz", 2},
      {"3 um", 3e-6},
      {"3 µm", 3e-6},
      {"50 ns", 5e-8},

      {"2 h", 7200},
      {"6 rpm", 0.2 * std::numbers::pi},
      {"7 J/(kg K)", 7},
      {"  ", -1},
      {"1 m \t", 1},
  };
  for (const Written& each : all) {
    Quantity quantity;
    const bool read = Quantity::parse(each.text, quantity);
    EXPECT_EQ(read, each.si != -1) << each.text;
    if (!read) continue;
    EXPECT_NEAR(Unit::to_si(quantity.number, quantity.unit), each.si, 1e-14 * std::abs(each.si))
        << each.text;
  }
}

TEST(Quantity, RefusesWhatIsNoNumberWithAUnit) {
  for (const char* text : {"",
                           "mm",
                           "nan",
                           "NaN",
                           "inf",
                           "-inf",
                           "infinity",
                           "1e999",
                           "-1e999",
                           "1e-999",
                           "0x10",
                           "0x1p3",
                           "1,5",
                           "1_000",
                           "1'000",
                           "++1",
                           "+-1",
                           "--1",
                           "+",
                           "-",
                           "1e",
                           "1e+",
                           "1e5e3",
                           "1.5.3",
                           "5 3",
                           "5 3 m",
                           "1 10 m",
                           "1 m 2",
                           "1 m^0.5",
                           "1 m.5",
                           "1 K @ 5",
                           "1 m/s from 3",
                           "1 s since 2000",
                           "1 lg(re 1 mW)",
                           "1 m\n",
                           "1 m;",
                           "1 m\nkg",
                           "1 foo",
                           "1 Pas",
                           "1 -m",
                           "1 kg/m3/",
                           "1 m(",
                           "1 /s",
                           "1 0",
                           "\xd9\xa1",
                           "1 \xff",
                           "1 é"}) {
    Quantity quantity;
    EXPECT_FALSE(Quantity::parse(text, quantity)) << text;
  }
  Quantity quantity;
  EXPECT_FALSE(Quantity::parse("1 " + std::string(10'000, 'm'), quantity));
}

TEST(Quantity, KeepsNumberAndUnitAsWritten) {
  Quantity quantity;
  ASSERT_TRUE(Quantity::parse("-0.25  kg/m^3 ", quantity));
  EXPECT_EQ(quantity.number, -0.25);
  EXPECT_EQ(quantity.unit, "kg/m^3");
}

// The units that are known without the database are the database's own: in brackets, it is asked.
TEST(Unit, BuiltInUnitsAreThoseOfTheDatabase) {
  for (const std::string name :
       {"1",  "%",   "m",    "cm",   "mm",  "um",  "s",    "ms",    "us",    "min",    "m2",
        "m3", "m/s", "m/s2", "mm/s", "1/s", "kg",  "g",    "kg/m3", "g/cm3", "kg/m^3", "m/s^2",
        "N",  "N/m", "Pa",   "kPa",  "MPa", "GPa", "Pa s", "J",     "K",     "rad",    "deg"}) {
    const std::string asked = "(" + name + ")";
    EXPECT_TRUE(Unit::convertible(name, asked)) << name;
    EXPECT_DOUBLE_EQ(Unit::to_si(1.7, name), Unit::to_si(1.7, asked)) << name;
    EXPECT_DOUBLE_EQ(Unit::from_si(1.7, name), Unit::from_si(1.7, asked)) << name;
  }
}

TEST(Unit, ConvertsOnlyWithinADimension) {
  const auto convertible = [](const char* a, const char* b) {
    EXPECT_EQ(Unit::convertible(a, b), Unit::convertible(b, a));
    return Unit::convertible(a, b);
  };
  EXPECT_TRUE(convertible("mm", "km"));
  EXPECT_TRUE(convertible("Pa s", "kg/m/s"));
  EXPECT_TRUE(convertible("N m", "J"));
  EXPECT_TRUE(convertible("degC", "K"));
  EXPECT_TRUE(convertible("deg", "rad"));
  EXPECT_TRUE(convertible("deg", "1"));
  EXPECT_TRUE(convertible("%", ""));
  EXPECT_TRUE(convertible("rad/s", "1/s"));
  EXPECT_FALSE(convertible("m", "kg"));
  EXPECT_FALSE(convertible("Pa", "Pa s"));
  EXPECT_FALSE(convertible("m", ""));
  EXPECT_FALSE(convertible("s", "Hz"));  // udunits would take one for the inverse of the other
  EXPECT_FALSE(convertible("foo", "foo"));
}

TEST(Unit, FromSiIsTheInverse) {
  for (const char* unit : {"mm", "kg/m^3", "degC", "deg", "%", "rpm", "g/cm3", "bar"}) {
    EXPECT_DOUBLE_EQ(Unit::from_si(Unit::to_si(12.5, unit), unit), 12.5) << unit;
  }
  EXPECT_DOUBLE_EQ(Unit::from_si(293.15, "degC"), 20.0);
}

TEST(Unit, AnInvalidUnitIsAnError) {
  EXPECT_THROW((void)Unit::to_si(1, "foo"), std::invalid_argument);
  EXPECT_THROW((void)Unit::from_si(1, "3 m"), std::invalid_argument);
  EXPECT_FALSE(Unit::valid("foo"));
  EXPECT_TRUE(Unit::valid(""));
  EXPECT_TRUE(Unit::valid("1"));
}

TEST(Shortest, ReadsBackAsTheSameDouble) {
  for (const double number : {0.1, 1.0 / 3, 5e-324, 1.7976931348623157e308, 1e22, -2.5e-9, 1e100}) {
    EXPECT_EQ(std::stod("0") + std::strtod(shortest(number).c_str(), nullptr), number);
  }
  EXPECT_EQ(shortest(0.1), "0.1");
  EXPECT_EQ(shortest(1e-6), "1e-06");
}

}  // namespace
}  // namespace sandglass
