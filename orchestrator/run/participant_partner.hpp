#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "coupling/engine.hpp"
#include "exchange/field.hpp"
#include "participant/participant.hpp"
#include "process/process.hpp"
#include "workflow/model.hpp"

namespace sandglass::run {

/// Which fields a participant receives and sends, as positions in the workflow's list.
struct Sides {
  std::vector<std::size_t> inputs;
  std::vector<std::size_t> outputs;
};

Sides sides_of(const workflow::Coupling& coupling, const std::string& name);

/// How these fields look in the slot of the side that receives (or sends) them.
std::vector<exchange::FieldLayout> layouts(const workflow::Coupling& coupling,
                                           const std::vector<std::size_t>& fields, bool received);

/// Joins the engine's view of a partner (fields by number) to a participant and its slot.
class ParticipantPartner final : public coupling::Partner {
 public:
  ParticipantPartner(participant::Participant& participant, Sides sides)
      : participant_(participant), sides_(std::move(sides)) {}

  [[nodiscard]] const std::string& name() const override { return participant_.name(); }
  void give(std::size_t field, std::span<const double> values,
            const coupling::Shape& shape) override {
    participant_.slot().give(position(sides_.inputs, field), values, shape);
  }
  void begin(std::int64_t window, std::int64_t iteration, double begin, double end) override {
    participant_.begin({window, iteration, begin, end});
  }
  void finish() override { participant_.finish(); }
  [[nodiscard]] Sent take(std::size_t field) override {
    auto taken = participant_.slot().take(position(sides_.outputs, field));
    return {taken.values, std::move(taken.shape)};
  }
  void save() override { participant_.save(); }
  void restore() override { participant_.restore(); }
  [[nodiscard]] double seconds() const override { return participant_.seconds(); }
  [[nodiscard]] std::string end_of_log() const override {
    return sandglass::end_of_log(participant_.log());
  }

 private:
  static std::size_t position(const std::vector<std::size_t>& list, std::size_t field) {
    return static_cast<std::size_t>(std::find(list.begin(), list.end(), field) - list.begin());
  }
  participant::Participant& participant_;
  Sides sides_;
};

}  // namespace sandglass::run
