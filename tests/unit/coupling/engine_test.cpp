#include "coupling/engine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numeric>

#include "../support/errors.hpp"

namespace sandglass::coupling {
namespace {

using test::error_of;
using testing::AllOf;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;
using Numbers = std::vector<double>;

/// Stands still unless somebody moves it.
class FakeClock final : public Clock {
 public:
  [[nodiscard]] double now() const override { return time; }
  double time = 100;
};

/// A partner in memory: what it does in a window is a function.
class FakePartner final : public Partner {
 public:
  FakePartner(std::string name, std::function<void(FakePartner&)> work,
              std::vector<std::string>* diary = nullptr)
      : name_(std::move(name)), work_(std::move(work)), diary_(diary) {}

  [[nodiscard]] const std::string& name() const override { return name_; }
  void give(std::size_t field, std::span<const double> values, const Shape& shape) override {
    received[field] = {values.begin(), values.end()};
    received_shape[field] = shape;
    note("given " + std::to_string(field));
  }
  void begin(std::int64_t index, std::int64_t, double begin_time, double end_time) override {
    window = index;
    from = begin_time;
    to = end_time;
    note("begin");
  }
  void finish() override {
    work_(*this);
    note("finish");
  }
  [[nodiscard]] Sent take(std::size_t field) override {
    return {sent.at(field), sent_shape.at(field)};
  }
  void save() override {}
  void restore() override {}
  [[nodiscard]] double seconds() const override { return own_seconds; }

  void send(std::size_t field, Numbers values, Shape shape = {}) {
    if (shape.empty()) shape = {static_cast<std::int64_t>(values.size())};
    sent[field] = std::move(values);
    sent_shape[field] = std::move(shape);
  }

  std::map<std::size_t, Numbers> received;
  std::map<std::size_t, Shape> received_shape;
  std::map<std::size_t, Numbers> sent;
  std::map<std::size_t, Shape> sent_shape;
  std::int64_t window = 0;
  double from = 0;
  double to = 0;
  double own_seconds = 0;

 private:
  void note(const std::string& what) {
    if (diary_ != nullptr) diary_->push_back(name_ + " " + what);
  }

  std::string name_;
  std::function<void(FakePartner&)> work_;
  std::vector<std::string>* diary_;
};

const auto kNothing = [](FakePartner&) {};
const auto kIgnoreBefore = [](std::int64_t) {};
const auto kIgnoreAfter = [](const Done&) {};

Field field(std::string name, std::size_t from, std::size_t to, Shape shape = {1}) {
  Field made;
  made.name = std::move(name);
  made.shape = std::move(shape);
  made.from = from;
  made.to = to;
  made.received_shape = made.shape;
  return made;
}

Plan plan_of(Scheme scheme, double window, std::int64_t windows, std::vector<Field> fields) {
  Plan plan;
  plan.scheme = scheme;
  plan.window = window;
  plan.windows = windows;
  plan.fields = std::move(fields);
  // What the watch finds has its own tests; here the bare scheme is looked at.
  plan.stability.active = false;
  return plan;
}

/// All windows of the plan.
std::vector<Oscillation> run(const Plan& plan, const std::vector<Partner*>& partners,
                             const Clock& clock, const std::function<void(std::int64_t)>& before,
                             const std::function<void(const Done&)>& after) {
  Engine engine(plan, partners, clock);
  for (std::int64_t index = 1; index <= plan.windows; ++index) {
    before(index);
    after(engine.window(index));
  }
  return engine.oscillations();
}

// ---- order and lag

class Order : public testing::Test {
 protected:
  std::vector<std::string> run_two_windows(Scheme scheme) {
    std::vector<std::string> diary;
    FakePartner fluid(
        "fluid", [](FakePartner& self) { self.send(0, {1}); }, &diary);
    FakePartner grains(
        "grains", [](FakePartner& self) { self.send(1, {1}); }, &diary);
    const Plan plan = plan_of(scheme, 0.5, 2, {field("drag", 0, 1), field("velocity", 1, 0)});
    run(
        plan, {&fluid, &grains}, FakeClock(),
        [&](std::int64_t window) { diary.push_back("before " + std::to_string(window)); },
        [&](const Done& done) { diary.push_back("after " + std::to_string(done.window)); });
    return diary;
  }
};

TEST_F(Order, SerialIsOneAfterTheOther) {
  EXPECT_THAT(run_two_windows(Scheme::serial_explicit),
              ElementsAre("before 1", "fluid given 1", "fluid begin", "fluid finish",
                          "grains given 0", "grains begin", "grains finish", "after 1", "before 2",
                          "fluid given 1", "fluid begin", "fluid finish", "grains given 0",
                          "grains begin", "grains finish", "after 2"));
}

TEST_F(Order, ParallelIsAllAtOnce) {
  EXPECT_THAT(run_two_windows(Scheme::parallel_explicit),
              ElementsAre("before 1", "fluid given 1", "fluid begin", "grains given 0",
                          "grains begin", "fluid finish", "grains finish", "after 1", "before 2",
                          "fluid given 1", "fluid begin", "grains given 0", "grains begin",
                          "fluid finish", "grains finish", "after 2"));
}

/// Each adds 1 to what the other has sent: the newest value shows how old it is on arrival.
Numbers lag(Scheme scheme) {
  Numbers arrived;
  FakePartner first(
      "first", [](FakePartner& self) { self.send(0, {10.0 * static_cast<double>(self.window)}); });
  FakePartner second("second", [&](FakePartner& self) {
    arrived.push_back(self.received[0].at(0));
    self.send(1, {0});
  });
  Plan plan = plan_of(scheme, 1, 4, {field("a", 0, 1), field("b", 1, 0)});
  plan.fields[0].initial = -7;
  run(plan, {&first, &second}, FakeClock(), kIgnoreBefore, kIgnoreAfter);
  return arrived;
}

TEST(Lag, InSerialTheSecondGetsThisWindowsValues) {
  EXPECT_THAT(lag(Scheme::serial_explicit), ElementsAre(10, 20, 30, 40));
}

TEST(Lag, InParallelTheSecondGetsTheLastWindowsValues) {
  EXPECT_THAT(lag(Scheme::parallel_explicit), ElementsAre(-7, 10, 20, 30));
}

TEST(Windows, AreProductsNotSums) {
  Numbers begins;
  Numbers ends;
  FakePartner only("only", [&](FakePartner& self) {
    begins.push_back(self.from);
    ends.push_back(self.to);
  });
  std::int64_t windows = 0;
  run(plan_of(Scheme::serial_explicit, 0.1, 1000, {}), {&only}, FakeClock(), kIgnoreBefore,
      [&](const Done& done) {
        ++windows;
        EXPECT_EQ(done.window, windows);
        EXPECT_EQ(done.iterations, 1);
        EXPECT_EQ(done.end, ends.back());
        EXPECT_EQ(done.begin, begins.back());
      });
  EXPECT_EQ(windows, 1000);
  EXPECT_EQ(begins.front(), 0);
  EXPECT_EQ(ends.back(), 1000 * 0.1);
  for (size_t i = 1; i < ends.size(); ++i) ASSERT_EQ(begins[i], ends[i - 1]);
}

// ---- a sphere in Stokes flow: the amplification factors that theory gives

/// Differences from the terminal velocity, window after window, of a sphere whose drag is
/// exchanged once per window: the sphere moves in `substeps` steps under the drag it was given, the
/// fluid answers the velocity it was given. `lambda` = window / relaxation time.
Numbers sphere(Scheme scheme, double lambda, int substeps, std::int64_t windows) {
  constexpr double relaxation_time = 1.4e-3;  // s
  constexpr double acceleration = 6.0;        // m/s2, gravity less buoyancy
  const double window = lambda * relaxation_time;
  const double terminal = acceleration * relaxation_time;
  double velocity = 0;
  Numbers differences{velocity - terminal};
  FakePartner fluid("fluid", [&](FakePartner& self) {
    self.send(0, {self.received[1].at(0) / relaxation_time});  // drag per mass
  });
  FakePartner grains("grains", [&](FakePartner& self) {
    for (int i = 0; i < substeps; ++i) {
      velocity += (self.to - self.from) / substeps * (acceleration - self.received[0].at(0));
    }
    self.send(1, {velocity});
    differences.push_back(velocity - terminal);
  });
  const Plan plan =
      plan_of(scheme, window, windows, {field("drag", 0, 1), field("velocity", 1, 0)});
  run(plan, {&fluid, &grains}, FakeClock(), kIgnoreBefore, kIgnoreAfter);
  return differences;
}

class Sphere : public testing::TestWithParam<std::pair<double, int>> {};

TEST_P(Sphere, SeriallyCoupledErrorsShrinkByOneMinusLambda) {
  const auto [lambda, substeps] = GetParam();
  const Numbers difference = sphere(Scheme::serial_explicit, lambda, substeps, 12);
  for (size_t n = 1; n < difference.size(); ++n) {
    // An error that has died out is all rounding.
    if (std::abs(difference[n - 1]) < 1e-6 * std::abs(difference[0])) break;
    EXPECT_THAT(difference[n] / difference[n - 1], DoubleNear(1 - lambda, 1e-9)) << "window " << n;
  }
}

TEST_P(Sphere, CoupledInParallelTheyFollowTheRootsOfTheLaggedEquation) {
  const auto [lambda, substeps] = GetParam();
  const Numbers difference = sphere(Scheme::parallel_explicit, lambda, substeps, 12);
  const double scale =
      std::abs(*std::max_element(difference.begin(), difference.end(),
                                 [](double a, double b) { return std::abs(a) < std::abs(b); }));
  // z^2 - z + lambda = 0, as a recursion for each of its solutions and so for their sum. Each
  // waits for the other, so the drag of window n is that of the velocity two windows ago.
  for (size_t n = 2; n < difference.size(); ++n) {
    EXPECT_THAT(difference[n] - difference[n - 1] + lambda * difference[n - 2],
                DoubleNear(0, 1e-9 * scale))
        << "window " << n;
  }
}

INSTANTIATE_TEST_SUITE_P(Theory, Sphere,
                         testing::Values(std::pair{0.3, 1}, std::pair{0.3, 100},
                                         std::pair{0.679, 1}, std::pair{0.679, 7},
                                         std::pair{1.5, 1}, std::pair{1.99, 100},
                                         std::pair{2.01, 1}, std::pair{2.01, 100}));

TEST(SphereLimits, SerialIsStableToTwoRelaxationTimes) {
  const auto growth = [](double lambda) {
    const Numbers difference = sphere(Scheme::serial_explicit, lambda, 3, 2000);
    return std::abs(difference.back() / difference.front());
  };
  EXPECT_LT(growth(1.99), 1e-3);
  EXPECT_GT(growth(2.01), 1e3);
}

TEST(SphereLimits, ParallelIsStableToOne) {
  const auto growth = [](double lambda) {
    const Numbers difference = sphere(Scheme::parallel_explicit, lambda, 3, 4000);
    return std::abs(difference.back() / difference.front());
  };
  EXPECT_LT(growth(0.99), 1e-3);
  EXPECT_GT(growth(1.01), 1e3);
}

// ---- values on their way

TEST(Values, StartAsTheWorkflowSays) {
  Numbers drag;
  Numbers mean;
  FakePartner first("first", [&](FakePartner& self) {
    drag = self.received[0];
    mean = self.received[1];
    self.send(2, {5, 6});
  });
  FakePartner second("second", [](FakePartner& self) {
    self.send(0, {1, 2, 3});
    self.send(1, {1, 2, 3});
  });
  Plan plan =
      plan_of(Scheme::serial_explicit, 1, 1,
              {field("drag", 1, 0, {3}), field("samples", 1, 0, {3}), field("x", 0, 1, {2})});
  plan.fields[0].initial = 2.5;
  plan.fields[1].initial = 9;
  plan.fields[1].received_shape = {1};
  plan.fields[1].transform = [](std::span<const double> values, const Shape&, Shape& result) {
    result = {1};
    return Numbers{std::accumulate(values.begin(), values.end(), 0.0)};
  };
  run(plan, {&first, &second}, FakeClock(), kIgnoreBefore, kIgnoreAfter);
  EXPECT_THAT(drag, ElementsAre(2.5, 2.5, 2.5));
  EXPECT_THAT(mean, ElementsAre(9));
}

TEST(Values, AreChangedOnTheWayButRecordedAsSent) {
  FakePartner grains("grains", [](FakePartner& self) { self.send(0, {1, 2, 6}); });
  FakePartner fluid("fluid", kNothing);
  Plan plan = plan_of(Scheme::serial_explicit, 1, 1, {field("velocity", 0, 1, {3})});
  plan.fields[0].received_shape = {1};
  plan.fields[0].transform = [](std::span<const double> values, const Shape& shape, Shape& result) {
    EXPECT_THAT(shape, ElementsAre(3));
    result = {1};
    return Numbers{std::accumulate(values.begin(), values.end(), 0.0) / 3};
  };
  run(plan, {&grains, &fluid}, FakeClock(), kIgnoreBefore, [&](const Done& done) {
    EXPECT_THAT(Numbers(done.fields[0].values.begin(), done.fields[0].values.end()),
                ElementsAre(1, 2, 6));
    EXPECT_THAT(done.fields[0].shape, ElementsAre(3));
  });
  EXPECT_THAT(fluid.received[0], ElementsAre(3));
  EXPECT_THAT(fluid.received_shape[0], ElementsAre(1));
}

TEST(Values, OfAVariableFieldCrossWithTheirCount) {
  FakePartner grains("grains", [](FakePartner& self) {
    Numbers values(2 * static_cast<size_t>(self.window - 1), 1.0);
    self.send(0, values, {self.window - 1, 2});
  });
  std::vector<Shape> shapes;
  FakePartner fluid("fluid", [&](FakePartner& self) {
    shapes.push_back(self.received_shape[0]);
    EXPECT_EQ(self.received[0].size(), static_cast<size_t>(2 * self.received_shape[0][0]));
  });
  Plan plan = plan_of(Scheme::serial_explicit, 1, 4, {field("positions", 0, 1, {3, 2})});
  plan.fields[0].variable = true;
  std::vector<Shape> recorded;
  run(plan, {&grains, &fluid}, FakeClock(), kIgnoreBefore,
      [&](const Done& done) { recorded.push_back(done.fields[0].shape); });
  EXPECT_THAT(shapes, ElementsAre(Shape{0, 2}, Shape{1, 2}, Shape{2, 2}, Shape{3, 2}));
  EXPECT_EQ(recorded, shapes);
}

TEST(Values, BeforeAVariableFieldWasSentItHasNoRows) {
  FakePartner fluid("fluid", kNothing);
  FakePartner grains("grains", [](FakePartner& self) { self.send(0, {1, 2}, {1, 2}); });
  Plan plan = plan_of(Scheme::serial_explicit, 1, 1, {field("positions", 1, 0, {3, 2})});
  plan.fields[0].variable = true;
  run(plan, {&fluid, &grains}, FakeClock(), kIgnoreBefore, kIgnoreAfter);
  EXPECT_THAT(fluid.received_shape[0], ElementsAre(0, 2));
  EXPECT_TRUE(fluid.received[0].empty());
}

TEST(Values, AreMappedBetweenPointsOfTheSameWindowInWhateverOrder) {
  for (const Scheme scheme : {Scheme::serial_explicit, Scheme::parallel_explicit}) {
    for (const std::size_t grains : {0U, 1U}) {
      const std::size_t body = 1 - grains;
      FakePartner tips("grains", [](FakePartner& self) {
        self.send(0, {1});
        self.send(1, {static_cast<double>(self.window)});
      });
      std::vector<double> got;
      FakePartner wall("body", [&](FakePartner& self) {
        if (!self.received[0].empty()) got.push_back(self.received[0][0]);
        self.send(2, {10.0 * static_cast<double>(self.window)});
      });
      // What is mapped stands before the points between which it is mapped.
      Plan plan = plan_of(scheme, 1, 4,
                          {field("push", grains, body), field("tips", grains, kNobody),
                           field("wall", body, kNobody)});
      plan.fields[0].inputs = {1, 2};
      plan.fields[0].mapping = [](std::span<const double>, const Shape&,
                                  const std::vector<Field::Newest>& inputs, Shape& result) {
        result = {1};
        return Numbers{inputs[0].values[0] + inputs[1].values[0]};
      };
      std::vector<Partner*> partners{&tips, &wall};
      if (grains == 1) std::swap(partners[0], partners[1]);
      run(plan, partners, FakeClock(), kIgnoreBefore, kIgnoreAfter);
      const bool at_once = scheme == Scheme::parallel_explicit;
      // In turn, the wall moves after the tips, or has moved before them.
      const bool first = !at_once && grains == 0;
      EXPECT_EQ(got, first ? (Numbers{1, 12, 23, 34}) : (Numbers{11, 22, 33})) << grains;
    }
  }
}

TEST(Values, ForNobodyAreRecordedOnly) {
  FakePartner grains("grains", [](FakePartner& self) { self.send(0, {4}); });
  const Plan plan = plan_of(Scheme::serial_explicit, 1, 1, {field("energy", 0, kNobody)});
  double recorded = 0;
  run(plan, {&grains}, FakeClock(), kIgnoreBefore,
      [&](const Done& done) { recorded = done.fields[0].values[0]; });
  EXPECT_EQ(recorded, 4);
  EXPECT_TRUE(grains.received.empty());
}

// ---- what goes wrong

/// A run in which the grains send `bad` as "velocity" in window 3; the windows that were done.
struct Failing {
  explicit Failing(Numbers bad, Shape shape, bool variable = false, bool transformed = false) {
    FakePartner fluid("fluid", [](FakePartner& self) { self.send(0, {1}); });
    FakePartner grains("grains", [&](FakePartner& self) {
      if (self.window == 3) {
        self.send(1, bad, shape);
      } else {
        self.send(1, {1, 2, 3, 4}, {2, 2});
      }
    });
    Plan plan = plan_of(Scheme::serial_explicit, 1, 5,
                        {field("drag", 0, 1), field("velocity", 1, 0, {2, 2})});
    plan.fields[1].variable = variable;
    if (transformed) {
      plan.fields[1].received_shape = {1};
      plan.fields[1].transform = [](std::span<const double> values, const Shape&, Shape& result) {
        result = {1};
        return Numbers{1 / values[0]};
      };
    }
    error = error_of([&] {
      run(plan, {&fluid, &grains}, FakeClock(), kIgnoreBefore, [&](const Done&) { ++windows; });
    });
  }
  Error error = Error::usage("");
  int windows = 0;
};

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Faults, WhatIsNotANumberEndsTheRunAndIsNamed) {
  const Failing failing({1, 2, kNotANumber, 4}, {2, 2});
  EXPECT_EQ(failing.error.code(), ExitCode::unstable);
  EXPECT_THAT(failing.error.what(),
              AllOf(HasSubstr("participant grains"), HasSubstr("window 3"), HasSubstr("'velocity'"),
                    HasSubstr("not a number"), HasSubstr("position 2")));
  EXPECT_FALSE(test::remedy_of(failing.error).empty());
  EXPECT_EQ(failing.windows, 2) << "those before are whole";
}

TEST(Faults, EnergyThatTheCouplingMakesEndsTheRunAndIsNamed) {
  // 1, 1.1, 1.21, ... and half of it in each of two fields; the first window has none yet.
  const auto half = [](FakePartner& self) {
    return self.window < 2 ? 0.0 : 0.5 * std::pow(1.1, static_cast<double>(self.window - 2));
  };
  FakePartner fluid("fluid", [&](FakePartner& self) { self.send(0, {half(self)}); });
  FakePartner grains("grains", [&](FakePartner& self) { self.send(1, {half(self)}); });
  Plan plan = plan_of(Scheme::serial_explicit, 1, 20,
                      {field("drag", 0, kNobody), field("heat", 1, kNobody)});
  int windows = 0;
  const auto count = [&](const Done&) { ++windows; };
  plan.energy = {{"drag", "heat"}, 1.5};
  const Error error = error_of([&] {
    run(plan, {&fluid, &grains}, FakeClock(), kIgnoreBefore, count);
  });
  EXPECT_EQ(error.code(), ExitCode::unstable);
  EXPECT_THAT(error.what(), AllOf(HasSubstr("window 7"), HasSubstr("'drag' and 'heat'"),
                                  HasSubstr("1.61 times its first value")));
  EXPECT_EQ(windows, 6);
  plan.energy.fields.clear();
  run(plan, {&fluid, &grains}, FakeClock(), kIgnoreBefore, count);
  EXPECT_EQ(windows, 26) << "not watched";
}

TEST(Faults, WhatIsNotWatchedMayGrow) {
  // It doubles with alternating sign in every window, as no exchange in a stable coupling does.
  const auto grow = [](FakePartner& self) {
    self.send(0, {std::pow(-2.0, static_cast<double>(self.window))});
  };
  for (const bool watched : {false, true}) {
    FakePartner fluid("fluid", grow);
    FakePartner grains("grains", kNothing);
    Plan plan = plan_of(Scheme::serial_explicit, 1, 60, {field("count", 0, kNobody)});
    plan.stability.active = true;
    plan.fields[0].watched = watched;
    const auto all = [&] {
      run(plan, {&fluid, &grains}, FakeClock(), kIgnoreBefore, kIgnoreAfter);
    };
    if (watched) {
      EXPECT_EQ(error_of(all).code(), ExitCode::unstable);
    } else {
      EXPECT_NO_THROW(all());
    }
  }
}

TEST(Faults, SoDoesTheInfinite) {
  const Failing failing({1, 2, 3, -kInfinity}, {2, 2});
  EXPECT_EQ(failing.error.code(), ExitCode::unstable);
  EXPECT_THAT(failing.error.what(), AllOf(HasSubstr("infinite"), HasSubstr("position 3")));
}

TEST(Faults, SoDoesOneThatATransformHasMade) {
  const Failing failing({0, 2, 3, 4}, {2, 2}, false, true);
  EXPECT_EQ(failing.error.code(), ExitCode::unstable);
  EXPECT_THAT(failing.error.what(),
              AllOf(HasSubstr("participant grains"), HasSubstr("window 3"),
                    HasSubstr("'velocity' after its transform"), HasSubstr("infinite")));
  EXPECT_EQ(failing.windows, 2);
}

TEST(Faults, AWrongShapeIsToldBesideTheRightOne) {
  const Shape wrong[] = {{1, 2}, {3, 2}, {2, 3}, {2}, {4}, {2, 2, 1}, {2, -2}, {}};
  for (const Shape& shape : wrong) {
    const Failing failing({1, 2, 3, 4}, shape);
    EXPECT_EQ(failing.error.code(), ExitCode::participant) << testing::PrintToString(shape);
    EXPECT_THAT(failing.error.what(), AllOf(HasSubstr("participant grains"), HasSubstr("window 3"),
                                            HasSubstr("'velocity'"), HasSubstr("[2, 2]")));
    EXPECT_EQ(failing.windows, 2);
  }
}

TEST(Faults, AVariableFieldMayBeShorterButNotLongerOrWider) {
  EXPECT_EQ(Failing({1, 2}, {1, 3}, true).error.code(), ExitCode::participant);
  const Failing failing({1, 2, 3, 4}, {3, 2}, true);
  EXPECT_EQ(failing.error.code(), ExitCode::participant);
  EXPECT_THAT(failing.error.what(), HasSubstr("at most [2, 2]"));
}

TEST(Faults, AFieldThatWasForgottenIsNamed) {
  for (const bool variable : {false, true}) {
    const Failing failing({}, {-1, -1}, variable);
    EXPECT_EQ(failing.error.code(), ExitCode::participant);
    EXPECT_THAT(failing.error.what(), AllOf(HasSubstr("participant grains"), HasSubstr("window 3"),
                                            HasSubstr("'velocity' was not sent")));
  }
}

TEST(Faults, WhatAPartnerThrowsPassesThrough) {
  FakePartner broken("broken", [](FakePartner& self) {
    if (self.window == 2) throw Error::participant("broken is broken");
  });
  int windows = 0;
  const Error error = error_of([&] {
    run(plan_of(Scheme::parallel_explicit, 1, 5, {}), {&broken}, FakeClock(), kIgnoreBefore,
        [&](const Done&) { ++windows; });
  });
  EXPECT_STREQ(error.what(), "broken is broken");
  EXPECT_EQ(windows, 1);
}

// ---- where the time went

TEST(Timings, AddUp) {
  FakeClock clock;
  FakePartner fluid("fluid", [&](FakePartner& self) {
    clock.time += 3;
    self.own_seconds = 2.5;
    self.send(0, {1});
  });
  FakePartner grains("grains", [&](FakePartner& self) {
    clock.time += 1;
    self.own_seconds = 0.75;
  });
  Plan plan = plan_of(Scheme::serial_explicit, 1, 2, {field("drag", 0, 1)});
  plan.fields[0].transform = [&](std::span<const double> values, const Shape& shape,
                                 Shape& result) {
    clock.time += 0.5;
    result = shape;
    return Numbers(values.begin(), values.end());
  };
  run(plan, {&fluid, &grains}, clock, kIgnoreBefore, [&](const Done& done) {
    EXPECT_THAT(done.timing.partners, ElementsAre(2.5, 0.75)) << "by their own account";
    EXPECT_EQ(done.timing.exchange, 0.5);
    EXPECT_EQ(done.timing.working, 3.25) << "one waits for the other";
    EXPECT_EQ(done.timing.total, 4.5);
  });
  plan.scheme = Scheme::parallel_explicit;
  run(plan, {&fluid, &grains}, clock, kIgnoreBefore, [&](const Done& done) {
    EXPECT_EQ(done.timing.working, 2.5) << "the slower one is waited for";
  });
}

// ---- what was asked before

TEST(AskedOnce, TheSameQuestionIsNotAskedAgain) {
  for (const Scheme scheme : {Scheme::serial_explicit, Scheme::parallel_explicit}) {
    Plan plan = plan_of(scheme, 0.1, 6, {field("motion", 1, 0), field("force", 0, 1)});
    plan.asked_once = {true, false};
    std::vector<double> asked;
    FakePartner fluid("fluid", [&](FakePartner& self) {
      asked.push_back(self.received[0][0]);
      self.send(1, {2 * self.received[0][0]});
    });
    fluid.own_seconds = 0.5;
    const std::vector<double> motions{1, 1, 2, 2, 2, 1};
    std::vector<double> forces;
    FakePartner grains("grains", [&](FakePartner& self) {
      forces.push_back(self.received[1][0]);
      self.send(0, {motions.at(static_cast<std::size_t>(self.window - 1))});
    });
    const std::vector<Partner*> partners{&fluid, &grains};
    const FakeClock clock;
    Engine engine(plan, partners, clock);
    for (std::int64_t index = 1; index <= plan.windows; ++index) engine.window(index);
    EXPECT_EQ(asked, (std::vector<double>{0, 1, 2})) << "of each window's begin: 0 1 1 2 2 2";
    EXPECT_EQ(engine.spared(0).windows, 3);
    EXPECT_DOUBLE_EQ(engine.spared(0).seconds, 1.5);
    EXPECT_EQ(engine.spared(1).windows, 0);
    const bool serial = scheme == Scheme::serial_explicit;
    EXPECT_EQ(forces, serial ? (std::vector<double>{0, 2, 2, 4, 4, 4})
                             : (std::vector<double>{0, 0, 2, 2, 4, 4}));
  }
}

TEST(AskedOnce, ARelaxedFieldGoesOnTowardsTheSameAnswer) {
  Plan plan =
      plan_of(Scheme::serial_explicit, 0.1, 4, {field("motion", 1, 0), field("force", 0, 1)});
  plan.asked_once = {true, false};
  plan.acceleration = Acceleration::constant;
  plan.relaxation = 0.5;
  plan.fields[1].relaxed = true;
  FakePartner fluid("fluid", [&](FakePartner& self) { self.send(1, {8}); });
  std::vector<double> forces;
  FakePartner grains("grains", [&](FakePartner& self) {
    forces.push_back(self.received[1][0]);
    self.send(0, {0});
  });
  const std::vector<Partner*> partners{&fluid, &grains};
  const FakeClock clock;
  Engine engine(plan, partners, clock);
  for (std::int64_t index = 1; index <= plan.windows; ++index) engine.window(index);
  EXPECT_EQ(forces, (std::vector<double>{4, 6, 7, 7.5}));
  EXPECT_EQ(engine.spared(0).windows, 3);
}

TEST(Implicit, WhatAnIterationTriesOnItsWayIsNoMeasure) {
  // y = 1 + G x, with roots that Aitken's factor finds only through very large values.
  Plan plan =
      plan_of(Scheme::serial_implicit, 1, 8, {field("x", 1, 0, {4}), field("y", 0, 1, {4})});
  plan.acceleration = Acceleration::aitken;
  plan.relaxation = 0.5;
  plan.tolerance = 1e-4;
  plan.most_iterations = 5000;
  plan.fields[1].relaxed = true;
  const Numbers gain{-10, -46.4, -215.4, -1000};
  FakePartner one("one", [&](FakePartner& self) {
    Numbers y(4, 1.0);
    for (std::size_t i = 0; i < 4; ++i) y[i] += gain[i] * self.received[0][i];
    self.send(1, y);
  });
  FakePartner other("other", [](FakePartner& self) { self.send(0, self.received[1]); });
  Numbers ended;
  try {
    run(plan, {&one, &other}, FakeClock(), kIgnoreBefore,
        [&](const Done&) { ended = other.received[1]; });
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("did not converge"));
    return;
  }
  double far = 0, size = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    far += std::pow(ended[i] - 1 / (1 - gain[i]), 2);
    size += std::pow(1 / (1 - gain[i]), 2);
  }
  EXPECT_LT(std::sqrt(far / size), 1e-3);
}

// ---- oscillations

TEST(Oscillations, AreToldOfWhatSomebodyReceives) {
  Plan plan = plan_of(Scheme::serial_explicit, 0.1, 30,
                      {field("drag", 0, 1), field("drag_total", 0, kNobody)});
  plan.stability.active = true;
  FakePartner fluid("fluid", [](FakePartner& self) {
    const double swing = std::pow(-0.8, self.window);
    self.send(0, {swing});
    self.send(1, {3 * swing});
  });
  FakePartner grains("grains", kNothing);
  const auto found = run(
      plan, {&fluid, &grains}, FakeClock(), [](std::int64_t) {}, [](const Done&) {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].field, "drag");
  EXPECT_NEAR(found[0].finding.growth, 0.8, 1e-6);
}

// ---- rest

TEST(Rest, ComesWhenTheFieldHasBeenSmallForSoManyWindowsInARow) {
  Plan plan = plan_of(Scheme::serial_explicit, 0.1, 8, {field("passed", 0, kNobody, {2})});
  plan.rest = {"passed", 0.5, 3};
  const std::vector<double> passed{0, -0.5, 0.6, 0.5, -0.7, 0, 0, 0.1};
  FakePartner grains("grains", [&](FakePartner& self) {
    self.send(0, {0, passed.at(static_cast<std::size_t>(self.window - 1))});
  });
  const std::vector<Partner*> partners{&grains};
  const FakeClock clock;
  Engine engine(plan, partners, clock);
  std::vector<bool> at_rest;
  for (std::int64_t index = 1; index <= plan.windows; ++index) {
    engine.window(index);
    at_rest.push_back(engine.at_rest());
  }
  EXPECT_EQ(at_rest, (std::vector<bool>{false, false, false, false, false, false, false, true}));
}

TEST(Rest, IsNotLookedForUnlessAsked) {
  const Plan plan = plan_of(Scheme::serial_explicit, 0.1, 3, {field("passed", 0, kNobody)});
  FakePartner grains("grains", [](FakePartner& self) { self.send(0, {0}); });
  const std::vector<Partner*> partners{&grains};
  const FakeClock clock;
  Engine engine(plan, partners, clock);
  for (std::int64_t index = 1; index <= plan.windows; ++index) engine.window(index);
  EXPECT_FALSE(engine.at_rest());
}

// ---- memory

/// A sphere's velocity under a drag that another one computes: partners with a state of their own.
class Memorized : public testing::TestWithParam<std::pair<Scheme, Acceleration>> {
 protected:
  static constexpr std::int64_t kWindows = 30;

  /// Windows `first` to `last`; the state before them is given and the one behind them returned.
  struct State {
    double velocity = 0;
    Memory::Arrays memory;
    std::vector<double> drags;
    std::vector<std::string> oscillating;
  };
  static State go_on(State state, std::int64_t first, std::int64_t last) {
    const auto [scheme, acceleration] = GetParam();
    Plan plan = plan_of(scheme, 0.1, kWindows, {field("velocity", 1, 0), field("drag", 0, 1)});
    plan.stability.active = true;
    plan.rest = {"velocity", 1e6, kWindows};
    plan.acceleration = acceleration;
    plan.relaxation = 0.6;
    plan.fields[0].relaxed = acceleration != Acceleration::none;
    FakePartner fluid("fluid", [](FakePartner& self) {
      const double v = self.received[0][0];
      self.send(1, {-0.7 * v - 0.05 * v * std::abs(v)});
    });
    double before = state.velocity;
    FakePartner grains("grains", [&](FakePartner& self) {
      state.velocity = before + 1.0 + self.received[1][0];
      self.send(0, {state.velocity});
    });
    const FakeClock clock;
    const std::vector<Partner*> partners{&fluid, &grains};
    Engine engine(plan, partners, clock);
    if (first > 1) {
      Memory memory(state.memory);
      engine.remember(memory);
    }
    for (std::int64_t index = first; index <= last; ++index) {
      before = state.velocity;
      const Done done = engine.window(index);
      state.drags.push_back(done.fields[1].values[0]);
    }
    Memory memory;
    engine.remember(memory);
    state.memory = memory.arrays();
    for (const Oscillation& one : engine.oscillations()) {
      state.oscillating.push_back(one.field + one.finding.text());
    }
    return state;
  }
};

TEST_P(Memorized, BrokenAnywhereItEndsWithTheSameBits) {
  const State whole = go_on({}, 1, kWindows);
  for (std::int64_t cut = 1; cut < kWindows; ++cut) {
    State first = go_on({}, 1, cut);
    first.oscillating.clear();
    const State rest = go_on(first, cut + 1, kWindows);
    EXPECT_EQ(rest.drags, whole.drags) << cut;
    EXPECT_EQ(rest.memory, whole.memory) << cut;
    EXPECT_EQ(rest.oscillating, whole.oscillating) << cut;
  }
}

INSTANTIATE_TEST_SUITE_P(AllSchemes, Memorized,
                         testing::Values(std::pair{Scheme::serial_explicit, Acceleration::none},
                                         std::pair{Scheme::serial_explicit, Acceleration::constant},
                                         std::pair{Scheme::parallel_explicit,
                                                   Acceleration::constant},
                                         std::pair{Scheme::serial_implicit, Acceleration::constant},
                                         std::pair{Scheme::serial_implicit, Acceleration::aitken}));

TEST(EngineMemory, AnotherCheckpointIsRefused) {
  const Plan plan = plan_of(Scheme::serial_explicit, 0.1, 3, {field("drag", 0, kNobody)});
  FakePartner only("fluid", kNothing);
  const std::vector<Partner*> partners{&only};
  const FakeClock clock;
  Engine engine(plan, partners, clock);
  Memory memory(Memory::Arrays{{"velocity.sent", {1}}});
  EXPECT_EQ(error_of([&] { engine.remember(memory); }).code(), ExitCode::environment);
}

}  // namespace
}  // namespace sandglass::coupling
