#include "run/coupling_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/error.hpp"
#include "exchange/mapping.hpp"
#include "exchange/transform.hpp"

namespace sandglass::run {
namespace {

/// A field's mapping, made anew when points or cells have changed.
class MovingMapping {
 public:
  using Newest = coupling::Field::Newest;
  MovingMapping(std::string field, workflow::FieldMapping mapping)
      : field_(std::move(field)), mapping_(std::move(mapping)) {}

  /// `inputs` are points of the sender, points of the receiver, and cells, if the workflow names
  /// them.
  std::vector<double> operator()(std::span<const double> values, const coupling::Shape& shape,
                                 const std::vector<Newest>& inputs, coupling::Shape& result) {
    const Newest &from = inputs[0], &to = inputs[1];
    const std::int64_t components = shape.size() == 2 ? shape[1] : 1;
    result = shape;
    result[0] = 0;
    if (to.shape[0] == 0) return {};  // the receiver has not spoken yet
    if (shape[0] != from.shape[0]) {
      throw Error::participant(fmt::format("field '{}' has {} values, but there are {} points '{}'",
                                           field_, shape[0], from.shape[0], mapping_.from_points),
                               "a participant must send as many values as points");
    }
    if (from.shape[0] == 0) {
      if (!mapping_.conservative) return {};
      // Nothing acts on any of the receiver's points.
      result[0] = to.shape[0];
      return std::vector<double>(static_cast<std::size_t>(to.shape[0] * components), 0.0);
    }
    update(inputs);
    result[0] = to.shape[0];
    return mapping_.conservative ? made_->conservative(values, components)
                                 : made_->consistent(values, components);
  }

 private:
  void update(const std::vector<Newest>& inputs) {
    bool same = made_ && known_.size() == inputs.size();
    for (std::size_t i = 0; same && i < inputs.size(); ++i) {
      same = std::equal(known_[i].begin(), known_[i].end(), inputs[i].values.begin(),
                        inputs[i].values.end());
    }
    if (same) return;
    known_.clear();
    for (const Newest& one : inputs) known_.emplace_back(one.values.begin(), one.values.end());
    const std::size_t surface = mapping_.conservative ? 1 : 0;
    if (inputs[0].shape[1] != inputs[1].shape[1]) {
      throw Error::participant(
          fmt::format("field '{}' is mapped between points of {} and of {} coordinates", field_,
                      inputs[0].shape[1], inputs[1].shape[1]),
          "both sides need the same number");
    }
    exchange::Interface face;
    face.dimension = static_cast<int>(inputs[surface].shape[1]);
    face.points = known_[surface];
    if (inputs.size() > 2) {
      face.corners = static_cast<int>(inputs[2].shape[1]);
      for (const double number : known_[2]) face.cells.push_back(static_cast<std::int64_t>(number));
    } else {
      face.corners = 2;
      face.cells = exchange::chain(face.count());
    }
    try {
      made_.emplace(mapping_.method, face, known_[1 - surface], mapping_.limit);
    } catch (const Error& error) {
      throw Error::participant(fmt::format("mapping of field '{}' from '{}' to '{}': {}", field_,
                                           mapping_.from_points, mapping_.to_points, error.what()));
    }
  }

  std::string field_;
  workflow::FieldMapping mapping_;
  std::vector<std::vector<double>> known_;
  std::optional<exchange::Mapping> made_;
};

}  // namespace

coupling::Plan plan_of(const workflow::Workflow& workflow) {
  const workflow::Coupling& coupling = *workflow.coupling;
  coupling::Plan plan;
  plan.scheme = coupling.scheme;
  plan.acceleration = coupling.acceleration;
  plan.relaxation = coupling.relaxation;
  plan.reused_windows = coupling.reused_windows;
  plan.filter = coupling.filter;
  plan.tolerance = coupling.tolerance;
  plan.most_iterations = coupling.iterations;
  plan.stability = coupling.stability;
  plan.energy = coupling.energy;
  plan.rest = coupling.rest;
  plan.window = coupling.window;
  plan.windows = coupling.windows;
  const auto number = [&](const std::string& name) {
    const auto found = std::find(coupling.order.begin(), coupling.order.end(), name);
    return found == coupling.order.end() ? coupling::kNobody
                                         : static_cast<std::size_t>(found - coupling.order.begin());
  };
  for (const workflow::Field& field : coupling.fields) {
    coupling::Field planned;
    planned.name = field.name;
    planned.shape = field.shape;
    planned.variable = field.variable;
    planned.from = number(field.from);
    planned.to = number(field.to);
    planned.received_shape = field.received_shape;
    planned.initial = field.initial;
    planned.relaxed = field.relaxed;
    planned.watched = field.watched;
    if (field.transform != workflow::Transform::identity) {
      const auto transform = field.transform;
      const auto samples = field.samples;
      planned.transform = [transform, samples](std::span<const double> values,
                                               const coupling::Shape& shape,
                                               coupling::Shape& result) {
        result = exchange::transformed_shape(transform, shape, samples);
        return exchange::apply(transform, values, shape, samples);
      };
    }
    if (field.mapping) {
      planned.mapping = MovingMapping(field.name, *field.mapping);
      for (const std::string& input :
           {field.mapping->from_points, field.mapping->to_points, field.mapping->cells}) {
        const auto found = std::find_if(coupling.fields.begin(), coupling.fields.end(),
                                        [&](const auto& one) { return one.name == input; });
        if (found != coupling.fields.end()) {
          planned.inputs.push_back(static_cast<std::size_t>(found - coupling.fields.begin()));
        }
      }
    }
    plan.fields.push_back(std::move(planned));
  }
  plan.asked_once.assign(coupling.order.size(), false);
  for (const workflow::LeftOut& one : workflow.left_out) {
    if (one.unchanged_inputs && one.active) plan.asked_once[number(one.of)] = true;
  }
  return plan;
}

}  // namespace sandglass::run
