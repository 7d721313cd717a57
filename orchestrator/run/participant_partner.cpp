#include "run/participant_partner.hpp"

namespace sandglass::run {

Sides sides_of(const workflow::Coupling& coupling, const std::string& name) {
  Sides sides;
  for (std::size_t f = 0; f < coupling.fields.size(); ++f) {
    if (coupling.fields[f].to == name) sides.inputs.push_back(f);
    if (coupling.fields[f].from == name) sides.outputs.push_back(f);
  }
  return sides;
}

std::vector<exchange::FieldLayout> layouts(const workflow::Coupling& coupling,
                                           const std::vector<std::size_t>& fields, bool received) {
  std::vector<exchange::FieldLayout> result;
  for (const std::size_t f : fields) {
    const workflow::Field& field = coupling.fields[f];
    result.push_back({field.name, field.unit, received ? field.received_shape : field.shape});
  }
  return result;
}

}  // namespace sandglass::run
