#include "coupling/stability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace sandglass::coupling {
namespace {

constexpr int kBlock = 6;                // windows
constexpr std::size_t kComparisons = 5;  // growing blocks in a row
constexpr std::size_t kSwings = 5;       // slow ones, each larger than the one before
constexpr double kObvious = 1e3;         // growth that needs no more proof
constexpr double kExplosion = 20;        // twice in a row, with alternating sign: no physics does
constexpr double kRounding = 1e-10;      // of the field's size
constexpr double kExponential = 0.85;    // growth of the second half over that of the first
constexpr std::size_t kMostValues = 1024;

/// Large arrays are looked at in places evenly spread over rows and columns.
void sample(std::span<const double> values, std::size_t row, std::vector<double>& few) {
  if (values.size() <= kMostValues) {
    few.assign(values.begin(), values.end());
    return;
  }
  std::size_t stride = values.size() / kMostValues + 1;
  while (std::gcd(stride, row) != 1) ++stride;  // else it would meet the same columns in every row
  few.resize((values.size() - 1) / stride + 1);
  for (std::size_t i = 0; i < few.size(); ++i) few[i] = values[i * stride];
}

// Four sums and four maxima side by side: the processor does them at once, and one after the other
// they would be the dearest part of a short window.
constexpr std::size_t kLanes = 4;

double largest_of(const std::vector<double>& values) {
  std::array<double, kLanes> largest{};
  const std::size_t whole = values.size() / kLanes * kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      largest[lane] = std::max(largest[lane], std::abs(values[i + lane]));
    }
  }
  for (std::size_t i = whole; i < values.size(); ++i) {
    largest[0] = std::max(largest[0], std::abs(values[i]));
  }
  return *std::max_element(largest.begin(), largest.end());
}

/// Of arrays of the same length; 0 when one of them is empty.
double product_of(const std::vector<double>& a, const std::vector<double>& b) {
  const std::size_t size = std::min(a.size(), b.size());
  const std::size_t whole = size / kLanes * kLanes;
  std::array<double, kLanes> sums{};
  for (std::size_t i = 0; i < whole; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) sums[lane] += a[i + lane] * b[i + lane];
  }
  for (std::size_t i = whole; i < size; ++i) sums[0] += a[i] * b[i];
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

}  // namespace

std::optional<double> EnergyWatch::observe(double energy) {
  if (!(first_ > 0)) first_ = energy;
  if (!(first_ > 0) || energy <= most_ * first_) return std::nullopt;
  return energy / first_;
}

std::string Finding::text() const {
  return fmt::format("{} {:.3g} times per window{}", growth >= 1 ? "grows" : "decays", growth,
                     alternating ? ", with alternating sign" : "");
}

std::optional<Finding> StabilityWatch::observe(std::span<const double> values, std::size_t row) {
  if (!limits_.active) return std::nullopt;
  sample(values, row, now_);
  // Divided by the largest value, so that neither products nor sums overflow.
  scale_ = std::max(scale_, largest_of(now_));
  if (now_.size() != last_.size()) {
    // Another number of values: changes begin anew.
    std::swap(last_, now_);
    last_change_.clear();
    return std::nullopt;
  }
  if (scale_ == 0) return std::nullopt;
  change_.resize(now_.size());
  for (std::size_t i = 0; i < now_.size(); ++i) {
    change_[i] = now_[i] / scale_ - last_[i] / scale_;
  }
  const double product = product_of(change_, last_change_);
  const double size = largest_of(change_);
  const bool real = size > kRounding;
  const bool turned = real && product < 0;
  const std::optional<Finding> explosion = exploding(size * scale_, turned);
  const std::optional<Finding> slow = slow_growth(real ? size * scale_ : 0, turned);
  if (real) block_.largest = std::max(block_.largest, size * scale_);
  if (turned) ++block_.turns;
  std::swap(last_, now_);
  std::swap(last_change_, change_);
  if (explosion) return explosion;
  if (slow) return slow;
  if (++block_.windows < kBlock) return std::nullopt;
  close_block();
  return verdict();
}

std::optional<Finding> StabilityWatch::exploding(double size, bool turned) {
  const double growth = last_size_ > 0 && turned ? size / last_size_ : 0;
  const bool both = std::min(growth, last_growth_) >= kExplosion && size >= largest_ever_;
  const double per_window = std::sqrt(growth * last_growth_);
  last_size_ = size;
  last_growth_ = growth;
  largest_ever_ = std::max(largest_ever_, size);
  return both ? std::optional<Finding>({per_window, true}) : std::nullopt;
}

std::optional<Finding> StabilityWatch::slow_growth(double size, bool turned) {
  std::optional<Finding> found;
  if (turned) {
    swings_.push_back(std::exchange(swing_, {}));
    found = verdict_on_swings();
    if (swings_.size() > kSwings) {
      largest_swing_ = std::max(largest_swing_, swings_.front().largest);
      swings_.erase(swings_.begin());
    }
  }
  swing_.largest = std::max(swing_.largest, size);
  ++swing_.windows;
  return found;
}

std::optional<Finding> StabilityWatch::verdict_on_swings() const {
  // How much each of the newest swings has grown over the one before, as logarithms; faster ones
  // are for blocks.
  std::vector<double> growths;
  double windows = 0;
  for (std::size_t at = swings_.size(); at-- > 1;) {
    const Swing& now = swings_[at];
    const Swing& before = swings_[at - 1];
    if (now.windows <= kBlock || before.largest <= 0) break;
    const double growth = std::log(now.largest / before.largest);
    if (growth <= std::log(limits_.growth) * now.windows) break;
    growths.insert(growths.begin(), growth);
    windows += now.windows;
  }
  const double total = std::accumulate(growths.begin(), growths.end(), 0.0);
  const std::size_t half = growths.size() / 2;
  const bool long_enough = growths.size() + 1 >= kSwings;
  const bool exponential =
      long_enough &&
      std::accumulate(growths.end() - half, growths.end(), 0.0) >=
          kExponential * std::accumulate(growths.begin(), growths.begin() + half, 0.0);
  const bool obvious = growths.size() >= 2 && total >= std::log(kObvious);
  if (!exponential && !obvious) return std::nullopt;
  if (swings_.back().largest <= largest_swing_) return std::nullopt;
  return Finding{std::exp(total / windows), true};
}

void StabilityWatch::close_block() {
  if (!blocks_.empty() && block_.turns >= 2 && blocks_.back().largest > 0 && block_.largest > 0) {
    ++oscillating_blocks_;
    decay_ = std::pow(block_.largest / blocks_.back().largest, 1.0 / kBlock);
  }
  blocks_.push_back(block_);
  block_ = {};
  if (blocks_.size() > kComparisons + 1) {
    largest_before_ = std::max(largest_before_, blocks_.front().largest);
    blocks_.erase(blocks_.begin());
  }
}

std::optional<Finding> StabilityWatch::verdict() const {
  if (auto found = oscillating_growth()) return found;
  return exponential_growth();
}

std::optional<Finding> StabilityWatch::oscillating_growth() const {
  const double wanted = std::pow(limits_.growth, kBlock);
  std::size_t comparisons = 0;
  std::size_t at = blocks_.size() - 1;
  while (at > 0 && blocks_[at].turns >= 1 && blocks_[at - 1].largest > 0 &&
         blocks_[at].largest > wanted * blocks_[at - 1].largest) {
    --at;
    ++comparisons;
  }
  // Noise grows now and then, but seldom beyond everything before.
  if (comparisons == 0 || blocks_.back().largest <= wanted * largest_before_) return std::nullopt;
  const double total = blocks_.back().largest / blocks_[at].largest;
  if (comparisons < kComparisons && (comparisons < 2 || total < kObvious)) return std::nullopt;
  return Finding{std::pow(total, 1.0 / static_cast<double>(kBlock * comparisons)), true};
}

std::optional<Finding> StabilityWatch::exponential_growth() const {
  constexpr std::size_t needed = 5;  // ends of four blocks of growth: 24 windows
  if (blocks_.size() < needed) return std::nullopt;
  const Block* last = &blocks_.back();
  // A change of sign makes it an oscillation, or noise.
  if (std::any_of(last - 3, last + 1, [](const Block& block) { return block.turns > 0; })) {
    return std::nullopt;
  }
  const double begin = (last - 4)->largest;
  const double middle = (last - 2)->largest;
  const double end = last->largest;
  if (begin <= 0 || middle <= begin || end <= middle) return std::nullopt;
  const double first_half = std::log(middle / begin);
  const double second_half = std::log(end / middle);
  const double per_window = std::exp((first_half + second_half) / (4.0 * kBlock));
  if (per_window < limits_.monotone_growth) return std::nullopt;
  if (second_half < kExponential * first_half) return std::nullopt;
  return Finding{per_window, false};
}

std::optional<Finding> StabilityWatch::oscillation() const {
  if (oscillating_blocks_ < 1) return std::nullopt;
  return Finding{decay_, true};
}

void StabilityWatch::remember(Memory& memory, const std::string& name) {
  memory(name + ".last", last_);
  memory(name + ".change", last_change_);
  memory(name + ".scale", scale_);
  memory(name + ".last_size", last_size_);
  memory(name + ".last_growth", last_growth_);
  memory(name + ".largest_ever", largest_ever_);
  memory(name + ".largest_before", largest_before_);
  memory(name + ".oscillating_blocks", oscillating_blocks_);
  memory(name + ".decay", decay_);
  memory(name + ".largest_swing", largest_swing_);
  std::size_t count = blocks_.size();
  memory(name + ".blocks", count);
  blocks_.resize(count);
  const auto one = [&](Block& block, const std::string& at) {
    memory(at + ".largest", block.largest);
    memory(at + ".turns", block.turns);
    memory(at + ".windows", block.windows);
  };
  one(block_, name + ".block");
  for (std::size_t b = 0; b < count; ++b) one(blocks_[b], fmt::format("{}.block{}", name, b));
  std::size_t swings = swings_.size();
  memory(name + ".swings", swings);
  swings_.resize(swings);
  const auto swing = [&](Swing& each, const std::string& at) {
    memory(at + ".largest", each.largest);
    memory(at + ".windows", each.windows);
  };
  swing(swing_, name + ".swing");
  for (std::size_t s = 0; s < swings; ++s) swing(swings_[s], fmt::format("{}.swing{}", name, s));
}

}  // namespace sandglass::coupling
