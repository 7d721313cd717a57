#include "coupling/engine.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.hpp"

namespace sandglass::coupling {
namespace {

std::int64_t count_of(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<>());
}

std::string text_of(const Shape& shape) { return fmt::format("[{}]", fmt::join(shape, ", ")); }

template <typename What>
void require_finite(std::span<const double> values, What what) {
  const auto bad =
      std::find_if_not(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
  if (bad == values.end()) return;
  throw Error::unstable(
      fmt::format("{} holds {} at position {}", what(),
                  std::isnan(*bad) ? "a value that is not a number" : "an infinite value",
                  std::distance(values.begin(), bad)),
      "a shorter window, or better conditioned parameters, may keep the run stable; the record "
      "holds every window before this one");
}

/// The newest values of a field on both sides of its way.
struct State {
  std::vector<double> sent;
  Shape sent_shape;
  std::vector<double> received;  ///< stays empty without a transform
  Shape received_shape;
};

class Engine {
 public:
  Engine(const Plan& plan, const std::vector<Partner*>& partners, const Clock& clock)
      : plan_(plan), partners_(partners), clock_(clock), states_(plan.fields.size()) {
    for (std::size_t f = 0; f < plan.fields.size(); ++f) {
      const Field& field = plan.fields[f];
      State& state = states_[f];
      state.sent_shape = field.shape;
      // Nothing has been counted yet where the number of rows is found at run time.
      if (field.variable) state.sent_shape[0] = 0;
      state.sent.assign(static_cast<size_t>(count_of(state.sent_shape)), field.initial);
      state.received_shape = field.transform ? field.received_shape : state.sent_shape;
      if (field.transform) {
        state.received.assign(static_cast<size_t>(count_of(field.received_shape)), field.initial);
      }
    }
  }

  Done window(std::int64_t index) {
    const double start = clock_.now();
    Done done;
    done.window = index;
    // Products, not sums: the end of window n does not depend on how many came before.
    done.begin = static_cast<double>(index - 1) * plan_.window;
    done.end = static_cast<double>(index) * plan_.window;
    done.timing.partners.assign(partners_.size(), 0.0);
    if (plan_.scheme == Scheme::serial_explicit) {
      for (std::size_t p = 0; p < partners_.size(); ++p) {
        begin(p, done);
        finish(p, done);
        done.timing.working += done.timing.partners[p];
      }
    } else {
      for (std::size_t p = 0; p < partners_.size(); ++p) begin(p, done);
      for (std::size_t p = 0; p < partners_.size(); ++p) {
        finish(p, done);
        done.timing.working = std::max(done.timing.working, done.timing.partners[p]);
      }
    }
    for (const State& state : states_) done.fields.push_back({state.sent, state.sent_shape});
    done.timing.total = clock_.now() - start;
    return done;
  }

 private:
  void begin(std::size_t p, Done& done) {
    const double start = clock_.now();
    for (std::size_t f = 0; f < plan_.fields.size(); ++f) {
      if (plan_.fields[f].to != p) continue;
      const State& state = states_[f];
      const bool changed = static_cast<bool>(plan_.fields[f].transform);
      partners_[p]->give(f, changed ? state.received : state.sent, state.received_shape);
    }
    done.timing.exchange += clock_.now() - start;
    partners_[p]->begin(done.window, done.iterations, done.begin, done.end);
  }

  void finish(std::size_t p, Done& done) {
    partners_[p]->finish();
    done.timing.partners[p] += partners_[p]->seconds();
    const double start = clock_.now();
    for (std::size_t f = 0; f < plan_.fields.size(); ++f) {
      if (plan_.fields[f].from == p) accept(f, partners_[p]->take(f), done.window);
    }
    done.timing.exchange += clock_.now() - start;
  }

  void accept(std::size_t f, const Partner::Sent& sent, std::int64_t window) {
    const Field& field = plan_.fields[f];
    const auto from = [&] {
      return fmt::format("participant {}, window {}", partners_[field.from]->name(), window);
    };
    if (!sent.shape.empty() && sent.shape[0] < 0) {
      throw Error::participant(fmt::format("{}: field '{}' was not sent", from(), field.name),
                               "its script must send it before the end of every window");
    }
    const bool fits =
        sent.shape.size() == field.shape.size() &&
        std::equal(sent.shape.begin() + 1, sent.shape.end(), field.shape.begin() + 1) &&
        (field.variable ? sent.shape[0] <= field.shape[0] : sent.shape[0] == field.shape[0]);
    if (!fits) {
      throw Error::participant(
          fmt::format("{}: field '{}' was sent with shape {}, but the workflow says {}{}", from(),
                      field.name, text_of(sent.shape), field.variable ? "at most " : "",
                      text_of(field.shape)),
          "change the script or the field's 'shape'");
    }
    require_finite(sent.values, [&] { return fmt::format("{}: field '{}'", from(), field.name); });
    State& state = states_[f];
    state.sent.assign(sent.values.begin(), sent.values.end());
    state.sent_shape = sent.shape;
    if (field.transform) {
      state.received = field.transform(state.sent, state.sent_shape, state.received_shape);
      require_finite(state.received, [&] {
        return fmt::format("{}: field '{}' after its transform", from(), field.name);
      });
    } else {
      state.received_shape = state.sent_shape;
    }
  }

  const Plan& plan_;
  const std::vector<Partner*>& partners_;
  const Clock& clock_;
  std::vector<State> states_;
};

}  // namespace

void run(const Plan& plan, const std::vector<Partner*>& partners, const Clock& clock,
         const std::function<void(std::int64_t window)>& before,
         const std::function<void(const Done&)>& after) {
  Engine engine(plan, partners, clock);
  for (std::int64_t index = 1; index <= plan.windows; ++index) {
    before(index);
    after(engine.window(index));
  }
}

}  // namespace sandglass::coupling
