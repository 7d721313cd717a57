#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "coupling/memory.hpp"
#include "coupling/quasi_newton.hpp"
#include "coupling/relaxation.hpp"
#include "coupling/rest.hpp"
#include "coupling/scheme.hpp"
#include "coupling/stability.hpp"

/// Windows, schemes and their order: arithmetic over interfaces, without files and processes.
namespace sandglass::coupling {

using Shape = std::vector<std::int64_t>;

/// What the engine asks of a participant.
class Partner {
 public:
  virtual ~Partner() = default;
  [[nodiscard]] virtual const std::string& name() const = 0;
  /// Gives it the values of field number `field`.
  virtual void give(std::size_t field, std::span<const double> values, const Shape& shape) = 0;
  /// Starts it on a window; returns as soon as it works on it.
  virtual void begin(std::int64_t window, std::int64_t iteration, double begin, double end) = 0;
  /// Waits until it has done it.
  virtual void finish() = 0;
  /// What it has sent of field number `field`: at most the promised number of values, and the shape
  /// that it says they have (a first axis below zero: nothing was sent).
  struct Sent {
    std::span<const double> values;
    Shape shape;
  };
  [[nodiscard]] virtual Sent take(std::size_t field) = 0;
  /// Its state in memory, for schemes that repeat a window.
  virtual void save() = 0;
  virtual void restore() = 0;
  /// Seconds it has worked on its last window, by its own account.
  [[nodiscard]] virtual double seconds() const = 0;
  /// The end of what it has logged, for messages; may be empty.
  [[nodiscard]] virtual std::string end_of_log() const { return {}; }
};

/// A field that crosses between partners.
struct Field {
  std::string name;
  Shape shape;            ///< as sent
  bool variable = false;  ///< the first axis of `shape` is an upper limit
  std::size_t from = 0;   ///< number of the partner that sends it
  std::size_t to = 0;     ///< number of the partner that receives it, or kNobody
  /// In transit; empty for identity.
  std::function<std::vector<double>(std::span<const double>, const Shape&, Shape& result)>
      transform;
  /// The newest values of another field.
  struct Newest {
    std::span<const double> values;
    Shape shape;
  };
  /// In transit between points that are fields themselves, `inputs` by number; empty otherwise.
  std::function<std::vector<double>(std::span<const double>, const Shape&,
                                    const std::vector<Newest>& inputs, Shape& result)>
      mapping;
  std::vector<std::size_t> inputs;
  Shape received_shape;
  double initial = 0;  ///< every value before the sender has spoken
  /// What is received is relaxed: the unknown of the iteration, when there is one.
  bool relaxed = false;
  bool watched = true;  ///< for growth from window to window
};
inline constexpr std::size_t kNobody = static_cast<std::size_t>(-1);

struct Plan {
  Scheme scheme = Scheme::serial_explicit;
  double window = 0;         ///< s
  std::int64_t windows = 0;  ///< how many
  std::vector<Field> fields;
  Acceleration acceleration = Acceleration::none;
  double relaxation = 1;     ///< w, or the first w
  double tolerance = 1e-10;  ///< of serial_implicit: residual over largest value, both as 2-norms
  std::int64_t most_iterations = 100;
  std::int64_t reused_windows = 10;  ///< of iqn_ils: earlier windows whose iterations are used
  double filter = 1e-2;              ///< of iqn_ils: what a column must add, over its length
  StabilityLimits stability;
  EnergyLimits energy;
  RestLimits rest;
  /// By partner: it answers the same values the same way, always, and is not asked again. May be
  /// shorter than the partners: the others are asked.
  std::vector<bool> asked_once;
};

/// A field that swings from window to window although the run did not diverge.
struct Oscillation {
  std::string field;
  Finding finding;
};

/// Where the time of one window went, in seconds.
struct Timing {
  std::vector<double> partners;  ///< each partner's work, by its own account
  double working = 0;            ///< of that, what the window had to wait for: the sum of partners
                                 ///< that work in turn, the longest of those at the same time
  double exchange = 0;           ///< copying, checking and transforming fields
  double total = 0;              ///< the whole window, as the engine saw it
};

/// One window that is done: what was sent, in the order of the plan's fields.
struct Done {
  std::int64_t window = 0;
  std::int64_t iterations = 1;
  double begin = 0;
  double end = 0;
  struct Values {
    std::span<const double> values;
    Shape shape;
  };
  std::vector<Values> fields;
  Timing timing;
};

/// Runs the windows of a plan, one after the other.
class Engine {
 public:
  /// All of these must outlive the engine.
  Engine(const Plan& plan, const std::vector<Partner*>& partners, const Clock& clock);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// Runs the window of this index, counted from 1. What is returned holds until the next call.
  /// Throws Error::participant for an array of the wrong shape, Error::unstable for a value that is
  /// not finite, a field that diverges, energy that the coupling makes, or an iteration that does
  /// not converge, each naming participant, field and window, and passes on what partners throw.
  Done window(std::int64_t index);
  /// Whether the field of the plan's `rest` has been small for long enough: the run may end.
  [[nodiscard]] bool at_rest() const { return rest_watch_.at_rest(); }
  /// What oscillated so far without diverging, of what somebody receives: the rest does so only
  /// because of that, or by itself.
  [[nodiscard]] std::vector<Oscillation> oscillations() const;
  /// What was not asked of a partner because it had just been asked the same.
  struct Spared {
    std::int64_t windows = 0;  ///< iterations each for themselves
    double seconds = 0;        ///< at what the windows that it was asked took on average
  };
  [[nodiscard]] Spared spared(std::size_t partner) const;
  /// Keeps or recalls all that the next window depends on besides the partners' own states.
  void remember(Memory& memory);

 private:
  struct State;
  struct Question;
  /// Whether this partner has just been asked the same; else the question is kept.
  bool asked_already(std::size_t p);
  void in_turn(Done& done);
  void at_once(Done& done);
  void iterate(Done& done);
  [[nodiscard]] std::pair<std::size_t, double> worst_residual() const;
  void watch(std::int64_t window);
  void watch_energy(std::int64_t window);
  void begin(std::size_t p, Done& done);
  /// Returns the seconds that the partner worked.
  double finish(std::size_t p, Done& done);
  void accept(std::size_t f, const Partner::Sent& sent, std::int64_t window);
  /// All that the partner sent, to where it goes.
  void pass_on(std::size_t p, Done& done);
  void change_on_the_way(std::size_t f, std::int64_t window);
  /// Of a field, for messages.
  [[nodiscard]] std::string origin(std::size_t f, std::int64_t window) const;
  /// Takes the next value of a relaxed field, and gives its receiver what it gets.
  void relax(std::size_t f, std::span<const double> next);
  void relax_together();

  const Plan& plan_;
  const std::vector<Partner*>& partners_;
  const Clock& clock_;
  std::vector<State> states_;
  std::vector<Question> questions_;  ///< by partner
  QuasiNewton quasi_newton_;
  EnergyWatch energy_watch_;
  std::vector<std::size_t> energies_;  ///< fields whose values are added up
  RestWatch rest_watch_;
};

}  // namespace sandglass::coupling
