#include "coupling/engine.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "base/error.hpp"

namespace sandglass::coupling {
namespace {

std::int64_t count_of(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<>());
}

std::string text_of(const Shape& shape) { return fmt::format("[{}]", fmt::join(shape, ", ")); }

/// Quicker than to look at one after the other: a value that is not finite makes 0 times it nan.
bool all_finite(std::span<const double> values) {
  constexpr std::size_t lanes = 8;
  std::array<double, lanes> sums{};
  const std::size_t whole = values.size() / lanes * lanes;
  for (std::size_t i = 0; i < whole; i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) sums[lane] += 0.0 * values[i + lane];
  }
  for (std::size_t i = whole; i < values.size(); ++i) sums[0] += 0.0 * values[i];
  return std::accumulate(sums.begin(), sums.end(), 0.0) == 0.0;
}

/// `what` and `log` are asked for a message only.
template <typename What, typename Log>
void require_finite(std::span<const double> values, What what, Log log) {
  if (all_finite(values)) return;
  const auto bad =
      std::find_if_not(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
  throw Error::unstable(
      fmt::format("{} holds {} at position {}", what(),
                  std::isnan(*bad) ? "a value that is not a number" : "an infinite value",
                  std::distance(values.begin(), bad)),
      "a shorter window, or better conditioned parameters, may keep the run stable; the record "
      "holds every window before this one",
      log());
}

double norm(std::span<const double> values) {
  // Scaled, so that neither very large nor very small values leave the range of a double.
  double largest = 0;
  for (const double x : values) largest = std::max(largest, std::abs(x));
  if (largest == 0) return 0;
  double sum = 0;
  for (const double x : values) sum += (x / largest) * (x / largest);
  return largest * std::sqrt(sum);
}

/// The change over `size`, or where that is 0, over what was there.
double relative_residual(const std::vector<double>& now, std::span<const double> next,
                         double size) {
  if (now.size() != next.size()) return 1;
  std::vector<double> difference(now.size());
  for (std::size_t i = 0; i < now.size(); ++i) difference[i] = next[i] - now[i];
  const double change = norm(difference);
  return change == 0 ? 0 : change / (size == 0 ? norm(now) : size);
}

bool same_bytes(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

bool changed_on_the_way(const Field& field) {
  return field.transform || field.mapping || field.relaxed;
}

}  // namespace

/// The newest values of a field on both sides of its way.
struct Engine::State {
  std::vector<double> sent;
  Shape sent_shape;
  std::vector<double> received;  ///< stays empty where it is what was sent
  Shape received_shape;
  Relaxation relaxation;
  StabilityWatch watch;
  double residual = 0;  ///< of a relaxed field: |next - received| / scale(), before relaxation
  double size = 0;      ///< of a relaxed field in this iteration
  /// In windows that have converged: what an iteration tries on its way there is no measure.
  double largest = 0;
  std::vector<double> next;  ///< of a field that waits to be relaxed together with others
  bool waiting = false;

  /// A field that passes through zero is not asked for more digits than it had.
  [[nodiscard]] double scale() const { return std::max(largest, size); }
};

/// What a partner was asked last, in the order of the plan's fields.
struct Engine::Question {
  bool asked = false;
  bool same = false;  ///< the newest question is the one that was answered last
  std::vector<std::vector<double>> values;
  std::vector<Shape> shapes;
  std::int64_t answers = 0;
  double seconds = 0;  ///< of all answers
  std::int64_t spared = 0;
};

Engine::Engine(const Plan& plan, const std::vector<Partner*>& partners, const Clock& clock)
    : plan_(plan),
      partners_(partners),
      clock_(clock),
      questions_(partners.size()),
      quasi_newton_(plan.relaxation, plan.reused_windows, plan.filter),
      energy_watch_(plan.energy.growth),
      rest_watch_(plan.rest) {
  for (const Field& field : plan.fields) {
    State& state = states_.emplace_back(State{
        {}, {}, {}, {}, {plan.acceleration, plan.relaxation}, StabilityWatch(plan.stability)});
    state.sent_shape = field.shape;
    // Nothing has been counted yet where the number of rows is found at run time.
    if (field.variable) state.sent_shape[0] = 0;
    state.sent.assign(static_cast<size_t>(count_of(state.sent_shape)), field.initial);
    state.received_shape =
        field.transform || field.mapping ? field.received_shape : state.sent_shape;
    if (field.mapping) state.received_shape[0] = 0;
    if (changed_on_the_way(field)) {
      state.received.assign(static_cast<size_t>(count_of(state.received_shape)), field.initial);
    }
  }
  for (std::size_t f = 0; f < plan.fields.size(); ++f) {
    const auto& named = plan.energy.fields;
    if (std::find(named.begin(), named.end(), plan.fields[f].name) != named.end()) {
      energies_.push_back(f);
    }
  }
}

Engine::~Engine() = default;

Done Engine::window(std::int64_t index) {
  const double start = clock_.now();
  Done done;
  done.window = index;
  // Products, not sums: the end of window n does not depend on how many came before.
  done.begin = static_cast<double>(index - 1) * plan_.window;
  done.end = static_cast<double>(index) * plan_.window;
  done.timing.partners.assign(partners_.size(), 0.0);
  if (plan_.scheme == Scheme::serial_explicit) {
    in_turn(done);
  } else if (plan_.scheme == Scheme::parallel_explicit) {
    at_once(done);
  } else {
    iterate(done);
  }
  for (const State& state : states_) done.fields.push_back({state.sent, state.sent_shape});
  watch(index);
  done.timing.total = clock_.now() - start;
  return done;
}

std::vector<Oscillation> Engine::oscillations() const {
  std::vector<Oscillation> found;
  for (std::size_t f = 0; f < states_.size(); ++f) {
    if (plan_.fields[f].to == kNobody) continue;
    if (const auto one = states_[f].watch.oscillation()) {
      found.push_back({plan_.fields[f].name, *one});
    }
  }
  return found;
}

void Engine::in_turn(Done& done) {
  for (std::size_t p = 0; p < partners_.size(); ++p) {
    begin(p, done);
    done.timing.working += finish(p, done);
    pass_on(p, done);
  }
}

void Engine::at_once(Done& done) {
  for (std::size_t p = 0; p < partners_.size(); ++p) begin(p, done);
  for (std::size_t p = 0; p < partners_.size(); ++p) {
    done.timing.working = std::max(done.timing.working, finish(p, done));
  }
  // Mappings look at fields of both sides, which are all of the same moment only now.
  for (std::size_t p = 0; p < partners_.size(); ++p) pass_on(p, done);
}

void Engine::iterate(Done& done) {
  for (Partner* partner : partners_) partner->save();
  for (State& state : states_) state.relaxation.new_window();
  quasi_newton_.new_window();
  double first_residual = 0;
  for (done.iterations = 1;; ++done.iterations) {
    if (done.iterations > 1) {
      for (Partner* partner : partners_) partner->restore();
    }
    in_turn(done);
    const auto [worst, residual] = worst_residual();
    if (residual <= plan_.tolerance) {
      for (State& state : states_) state.largest = state.scale();
      return;
    }
    if (done.iterations == 1) first_residual = residual;
    if (done.iterations < plan_.most_iterations) continue;
    throw Error::unstable(
        fmt::format(
            "window {}: field '{}' did not converge in {} iterations: its residual went "
            "from {:.3g} to {:.3g}, {:.3g} times per iteration",
            done.window, plan_.fields[worst].name, done.iterations, first_residual, residual,
            std::pow(residual / first_residual,
                     1.0 / static_cast<double>(std::max<std::int64_t>(1, done.iterations - 1)))),
        "a smaller 'relaxation', acceleration=aitken, a shorter window or more 'iterations' may "
        "help");
  }
}

std::pair<std::size_t, double> Engine::worst_residual() const {
  std::pair<std::size_t, double> worst{0, 0.0};
  for (std::size_t f = 0; f < states_.size(); ++f) {
    if (plan_.fields[f].relaxed && states_[f].residual >= worst.second) {
      worst = {f, states_[f].residual};
    }
  }
  return worst;
}

void Engine::watch(std::int64_t window) {
  for (std::size_t f = 0; f < states_.size(); ++f) {
    if (plan_.fields[f].name == plan_.rest.field) rest_watch_.observe(states_[f].sent);
    if (!plan_.fields[f].watched) continue;
    const std::int64_t rows = states_[f].sent_shape[0];
    const std::size_t row = rows > 0 ? states_[f].sent.size() / static_cast<std::size_t>(rows) : 1;
    const auto found = states_[f].watch.observe(states_[f].sent, row);
    if (!found) continue;
    throw Error::unstable(
        fmt::format("window {}: field '{}' from {} diverges: its change {}", window,
                    plan_.fields[f].name, partners_[plan_.fields[f].from]->name(), found->text()),
        "a shorter window, under-relaxation, or scheme=serial-implicit may keep it stable; the "
        "limits are in 'coupling: stability'");
  }
  watch_energy(window);
}

void Engine::watch_energy(std::int64_t window) {
  if (energies_.empty()) return;
  double sum = 0;
  for (const std::size_t f : energies_) {
    sum = std::accumulate(states_[f].sent.begin(), states_[f].sent.end(), sum);
  }
  const std::optional<double> growth = energy_watch_.observe(sum);
  if (!growth) return;
  throw Error::unstable(
      fmt::format("window {}: the coupling makes energy: the sum of field '{}' is {:.3g} times its "
                  "first value, {:.3g} % more in every window",
                  window, fmt::join(plan_.energy.fields, "' and '"), *growth,
                  100 * (std::pow(*growth, 1 / static_cast<double>(window)) - 1)),
      "an exchange with a lag feeds an oscillation as long as it lasts: a shorter window, what is "
      "exchanged predicted within it, damping, or scheme=serial-implicit may help; the limits are "
      "in 'coupling: stability'");
}

bool Engine::asked_already(std::size_t p) {
  if (p >= plan_.asked_once.size() || !plan_.asked_once[p]) return false;
  Question& last = questions_[p];
  last.values.resize(plan_.fields.size());
  last.shapes.resize(plan_.fields.size());
  last.same = last.asked;
  for (std::size_t f = 0; f < plan_.fields.size(); ++f) {
    if (plan_.fields[f].to != p) continue;
    const State& state = states_[f];
    const auto& now = changed_on_the_way(plan_.fields[f]) ? state.received : state.sent;
    if (same_bytes(now, last.values[f]) && state.received_shape == last.shapes[f]) continue;
    last.same = false;
    last.values[f] = now;
    last.shapes[f] = state.received_shape;
  }
  last.asked = true;
  return last.same;
}

Engine::Spared Engine::spared(std::size_t partner) const {
  const Question& question = questions_[partner];
  const auto windows = static_cast<double>(question.spared);
  return {question.spared, question.answers > 0
                               ? windows * question.seconds / static_cast<double>(question.answers)
                               : 0.0};
}

void Engine::begin(std::size_t p, Done& done) {
  const double start = clock_.now();
  if (asked_already(p)) {
    done.timing.exchange += clock_.now() - start;
    return;
  }
  for (std::size_t f = 0; f < plan_.fields.size(); ++f) {
    if (plan_.fields[f].to != p) continue;
    const State& state = states_[f];
    partners_[p]->give(f, changed_on_the_way(plan_.fields[f]) ? state.received : state.sent,
                       state.received_shape);
  }
  done.timing.exchange += clock_.now() - start;
  partners_[p]->begin(done.window, done.iterations, done.begin, done.end);
}

double Engine::finish(std::size_t p, Done& done) {
  Question& question = questions_[p];
  double worked = 0;
  if (question.same) {
    ++question.spared;
  } else {
    partners_[p]->finish();
    worked = partners_[p]->seconds();
    ++question.answers;
    question.seconds += worked;
  }
  done.timing.partners[p] += worked;
  const double start = clock_.now();
  for (std::size_t f = 0; f < plan_.fields.size(); ++f) {
    if (plan_.fields[f].from == p && !question.same) accept(f, partners_[p]->take(f), done.window);
  }
  done.timing.exchange += clock_.now() - start;
  return worked;
}

void Engine::pass_on(std::size_t p, Done& done) {
  const double start = clock_.now();
  for (std::size_t f = 0; f < plan_.fields.size(); ++f) {
    if (plan_.fields[f].from == p) change_on_the_way(f, done.window);
  }
  done.timing.exchange += clock_.now() - start;
}

std::string Engine::origin(std::size_t f, std::int64_t window) const {
  const Field& field = plan_.fields[f];
  return fmt::format("participant {}, window {}: field '{}'", partners_[field.from]->name(), window,
                     field.name);
}

void Engine::accept(std::size_t f, const Partner::Sent& sent, std::int64_t window) {
  const Field& field = plan_.fields[f];
  const auto log = [&] { return partners_[field.from]->end_of_log(); };
  if (!sent.shape.empty() && sent.shape[0] < 0) {
    throw Error::participant(fmt::format("{} was not sent", origin(f, window)),
                             "its script must send it before the end of every window", log());
  }
  const bool fits =
      sent.shape.size() == field.shape.size() &&
      std::equal(sent.shape.begin() + 1, sent.shape.end(), field.shape.begin() + 1) &&
      (field.variable ? sent.shape[0] <= field.shape[0] : sent.shape[0] == field.shape[0]);
  if (!fits) {
    throw Error::participant(
        fmt::format("{} was sent with shape {}, but the workflow says {}{}", origin(f, window),
                    text_of(sent.shape), field.variable ? "at most " : "", text_of(field.shape)),
        "change the script or the field's 'shape'", log());
  }
  State& state = states_[f];
  require_finite(
      sent.values, [&] { return origin(f, window); }, log);
  state.sent.assign(sent.values.begin(), sent.values.end());
  state.sent_shape = sent.shape;
}

void Engine::change_on_the_way(std::size_t f, std::int64_t window) {
  const Field& field = plan_.fields[f];
  State& state = states_[f];
  std::vector<double> next;
  if (field.transform) {
    next = field.transform(state.sent, state.sent_shape, state.received_shape);
    require_finite(
        next, [&] { return origin(f, window) + " after its transform"; },
        [&] { return partners_[field.from]->end_of_log(); });
  } else if (field.mapping) {
    std::vector<Field::Newest> inputs;
    for (const std::size_t input : field.inputs) {
      inputs.push_back({states_[input].sent, states_[input].sent_shape});
    }
    next = field.mapping(state.sent, state.sent_shape, inputs, state.received_shape);
  } else {
    state.received_shape = state.sent_shape;
  }
  if (field.relaxed) {
    const std::span<const double> target = field.transform || field.mapping ? next : state.sent;
    relax(f, target);
  } else {
    state.received = std::move(next);
  }
}

void Engine::relax(std::size_t f, std::span<const double> next) {
  State& state = states_[f];
  state.size = norm(next);
  state.residual = relative_residual(state.received, next, state.scale());
  if (plan_.acceleration != Acceleration::iqn_ils) {
    state.relaxation.step(state.received, next);
    return;
  }
  state.next.assign(next.begin(), next.end());
  state.waiting = true;
  for (std::size_t other = 0; other < states_.size(); ++other) {
    if (plan_.fields[other].relaxed && !states_[other].waiting) return;
  }
  relax_together();
}

/// All relaxed fields as one vector of unknowns, each weighted by its size.
void Engine::relax_together() {
  std::vector<double> now;
  std::vector<double> next;
  std::vector<double> weights;
  for (std::size_t f = 0; f < states_.size(); ++f) {
    if (!plan_.fields[f].relaxed) continue;
    const State& state = states_[f];
    now.insert(now.end(), state.received.begin(), state.received.end());
    next.insert(next.end(), state.next.begin(), state.next.end());
    weights.insert(weights.end(), state.next.size(), state.scale() > 0 ? 1 / state.scale() : 1.0);
  }
  quasi_newton_.step(now, next, weights);
  auto from = now.begin();
  for (std::size_t f = 0; f < states_.size(); ++f) {
    if (!plan_.fields[f].relaxed) continue;
    State& state = states_[f];
    const auto to = from + static_cast<std::ptrdiff_t>(state.next.size());
    state.received.assign(from, to);
    state.waiting = false;
    from = to;
  }
}

void Engine::remember(Memory& memory) {
  quasi_newton_.remember(memory, "quasi_newton");
  energy_watch_.remember(memory, "energy");
  rest_watch_.remember(memory, "rest");
  for (std::size_t f = 0; f < states_.size(); ++f) {
    State& state = states_[f];
    const std::string& name = plan_.fields[f].name;
    memory(name + ".sent", state.sent);
    memory(name + ".sent_shape", state.sent_shape);
    memory(name + ".received", state.received);
    memory(name + ".received_shape", state.received_shape);
    memory(name + ".largest", state.largest);
    state.relaxation.remember(memory, name + ".relaxation");
    state.watch.remember(memory, name + ".watch");
  }
}

}  // namespace sandglass::coupling
