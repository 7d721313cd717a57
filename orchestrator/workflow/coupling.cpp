#include "workflow/coupling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/unit.hpp"

namespace sandglass::workflow {
namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> names_of(const std::vector<Field>& fields) {
  std::vector<std::string> names;
  names.reserve(fields.size());
  for (const Field& field : fields) names.push_back(field.name);
  return names;
}

/// The participants as written, and those of them that take part.
struct Order {
  std::vector<std::string> declared;  ///< all participants of the workflow
  std::vector<std::string> written;   ///< under `order`
  std::vector<std::string> running;   ///< of `order`, those that apply
};

Order read_order(const Context& context, const Section& section, const Workflow& workflow) {
  Order order{names_of(declared_in(context, "participants")), section.texts("order"), {}};
  const Node* list = section.find("order");
  std::set<std::string> seen;
  for (size_t i = 0; list && list->kind == Node::Kind::list && i < list->items.size(); ++i) {
    const Node& item = list->items[i];
    if (item.kind != Node::Kind::scalar || !is_name(item.text)) continue;
    if (!contains(order.declared, item.text)) {
      context.problems.unknown(context.scope.at(item), "there is no participant", item.text,
                               order.declared);
    } else if (!seen.insert(item.text).second) {
      context.problems.add(context.scope.at(item),
                           fmt::format("'{}' is twice in the order", item.text),
                           "a participant runs once in a window");
    }
  }
  for (const Participant& participant : workflow.participants) {
    if (list && !contains(order.written, participant.name)) {
      context.problems.add(participant.place,
                           fmt::format("participant '{}' is not in the order", participant.name),
                           "add it to 'order' of 'coupling', or remove it");
    }
  }
  for (const std::string& name : order.written) {
    const bool runs = std::any_of(workflow.participants.begin(), workflow.participants.end(),
                                  [&](const Participant& each) { return each.name == name; });
    if (runs && !contains(order.running, name)) order.running.push_back(name);
  }
  return order;
}

/// The fewest whole windows that reach the end. An end within rounding of a whole number of windows
/// counts as that number.
void read_windows(const Context& context, const Section& section, Coupling& coupling) {
  constexpr double most = 1e9;
  coupling.window = section.number("window", 0);
  coupling.end = section.number("end", 0);
  if (coupling.window <= 0 || coupling.end <= 0) return;  // missing or wrong: reported already
  const double ratio = coupling.end / coupling.window;
  const double nearest_whole = std::round(ratio);
  const bool whole = nearest_whole >= 1 && std::abs(ratio - nearest_whole) <= 1e-9 * ratio;
  const double windows = whole ? nearest_whole : std::ceil(ratio);
  if (!(windows <= most)) {
    context.problems.add(section.place("window"),
                         fmt::format("{} windows of {} s to reach {} s", shortest(windows),
                                     shortest(coupling.window), shortest(coupling.end)),
                         "at most 1e9: make the window longer or end earlier");
    return;
  }
  coupling.windows = static_cast<std::int64_t>(windows);
  if (!whole) coupling.end = windows * coupling.window;
}

Transform transform_of(const std::string& name) {
  static const std::map<std::string, Transform> transforms = {
      {"mean", Transform::mean},   {"median", Transform::median}, {"min", Transform::minimum},
      {"max", Transform::maximum}, {"sum", Transform::sum},       {"linear", Transform::linear}};
  const auto found = transforms.find(name);
  return found == transforms.end() ? Transform::identity : found->second;
}

/// Which fields are recorded.
struct Recorded {
  bool all = true;
  std::set<std::string> names;
};

Recorded read_record(const Context& context, const std::vector<std::string>& fields) {
  Recorded recorded;
  const Node* record = context.root.find("record");
  const Node* selection =
      record && record->kind == Node::Kind::map ? record->find("fields") : nullptr;
  if (!selection || selection->kind == Node::Kind::broken) return recorded;
  if (selection->kind == Node::Kind::scalar) {
    recorded.all = selection->text != "none";
    return recorded;
  }
  recorded.all = false;
  for (const Node& item : selection->items) {
    if (item.kind != Node::Kind::scalar || !is_name(item.text)) continue;
    if (!contains(fields, item.text)) {
      context.problems.unknown(context.scope.at(item), "there is no field", item.text, fields);
    }
    recorded.names.insert(item.text);
  }
  return recorded;
}

void read_checkpoints(const Context& context, Coupling& coupling) {
  const Node* record = context.root.find("record");
  if (!record || record->kind != Node::Kind::map) return;
  const Section section(*record, object("record"), context.scope);
  coupling.checkpoint_every = section.count("checkpoint_every", 0);
  coupling.checkpoints_kept = section.count("checkpoints_kept", 0);
}

/// A field's sender or receiver: declared, and in the order.
void check_end(const Context& context, const Section& section, const char* key,
               const Declared& field, const Order& order) {
  const std::string name = section.text(key);
  if (name.empty()) return;
  const std::string role = std::string(key) == "from" ? "sender" : "receiver";
  if (!contains(order.declared, name)) {
    context.problems.unknown(
        section.place(key),
        fmt::format("field '{}' is unreachable: its {} is no participant:", field.name, role), name,
        order.declared);
  } else if (!order.written.empty() && !contains(order.written, name)) {
    context.problems.add(section.place(key),
                         fmt::format("field '{}' is unreachable: its {} '{}' is not in the order",
                                     field.name, role, name),
                         "add it to 'order' of 'coupling'");
  }
}

/// How many values; beyond what a field may have it is only known to be more.
std::int64_t size_of(const std::vector<std::int64_t>& shape) {
  std::int64_t size = 1;
  for (const std::int64_t length : shape) {
    if (length > most_field_values / size) return most_field_values + 1;
    size *= length;
  }
  return size;
}

void read_transform(const Context& context, const Section& section, const Declared& declared,
                    Field& field) {
  field.transform = transform_of(section.text("transform"));
  field.samples = section.count("samples", 0);
  const bool linear = field.transform == Transform::linear;
  if (linear && !section.find("samples")) {
    context.problems.add(section.place("transform"),
                         fmt::format("the transform of '{}' needs 'samples'", declared.name),
                         "add the number of rows that arrive, such as samples: 10");
  }
  if (!linear && section.find("samples")) {
    context.problems.add(section.place("samples"), "'samples' belongs to the transform linear",
                         "remove it, or add transform: linear");
  }
  field.received_shape = exchange::transformed_shape(field.transform, field.shape, field.samples);
  if (linear && size_of(field.received_shape) > most_field_values) {
    context.problems.add(
        section.place("samples"),
        fmt::format("more than {} values of field '{}' arrive", most_field_values, declared.name),
        "fewer 'samples' will do");
  }
}

/// The fields that a mapping names: sent in the same run, and with the shape of points or cells.
void check_mapping_field(const Context& context, const Section& section, const char* key,
                         const std::string& sender, const std::vector<Field>& fields) {
  const std::string name = section.text(key);
  if (name.empty()) return;
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const Field& one) { return one.name == name; });
  if (found == fields.end()) {
    context.problems.unknown(section.place(key), "there is no field", name, names_of(fields));
    return;
  }
  const bool rows = found->shape.size() == 2 && (found->shape[1] == 2 || found->shape[1] == 3);
  if (!rows) {
    context.problems.add(section.place(key),
                         fmt::format("field '{}' cannot be points or cells", name),
                         "its shape must be [number, 2] or [number, 3]");
  }
  if (found->from != sender) {
    context.problems.add(
        section.place(key),
        fmt::format("field '{}' is sent by '{}', not by '{}'", name, found->from, sender),
        "name the points of the participant at this end");
  }
}

/// What a mapping and the fields that it names say of each other, as far as it is known before
/// anybody has sent anything.
void check_mapped_shapes(const Context& context, const Node& node, const Field& mapped,
                         const FieldMapping& mapping, const std::vector<Field>& fields) {
  const auto points = [&](const std::string& name) -> const Field* {
    const auto found = std::find_if(fields.begin(), fields.end(),
                                    [&](const Field& one) { return one.name == name; });
    return found != fields.end() && found->shape.size() == 2 ? &*found : nullptr;
  };
  const Field* from = points(mapping.from_points);
  const Field* to = points(mapping.to_points);
  if (!from || !to || mapped.shape.empty()) return;
  if (from->shape[1] != to->shape[1]) {
    context.problems.add(context.scope.at(node),
                         fmt::format("points '{}' have {} coordinates, points '{}' {}", from->name,
                                     from->shape[1], to->name, to->shape[1]),
                         "both sides need the same number");
  }
  if (!mapped.variable && !from->variable && mapped.shape[0] != from->shape[0]) {
    context.problems.add(context.scope.at(node),
                         fmt::format("field '{}' has {} values, but there are {} points '{}'",
                                     mapped.name, mapped.shape[0], from->shape[0], from->name),
                         "a participant must send as many values as points");
  }
  if (size_of(mapped.received_shape) > most_field_values) {
    context.problems.add(
        context.scope.at(node),
        fmt::format("more than {} values of field '{}' arrive", most_field_values, mapped.name),
        "make it smaller, or the points fewer");
  }
}

/// Mappings, once all fields are known.
void read_mappings(const Context& context, const Node& map, std::vector<Field>& fields) {
  for (size_t i = 0; i < map.keys.size(); ++i) {
    const Node* node =
        map.items[i].kind == Node::Kind::map ? map.items[i].find("mapping") : nullptr;
    const auto mine = std::find_if(fields.begin(), fields.end(),
                                   [&](const Field& one) { return one.name == map.keys[i].text; });
    if (!node || node->kind != Node::Kind::map || mine == fields.end() || mine->to.empty())
      continue;
    const Section section(*node, object("mapping"), context.scope);
    FieldMapping mapping;
    mapping.method = section.text("method") == "nearest" ? exchange::MappingMethod::nearest
                                                         : exchange::MappingMethod::linear;
    mapping.conservative = section.text("kind") == "conservative";
    mapping.from_points = section.text("from_points");
    mapping.to_points = section.text("to_points");
    mapping.cells = section.text("cells");
    mapping.limit = section.number("limit", 0);
    check_mapping_field(context, section, "from_points", mine->from, fields);
    check_mapping_field(context, section, "to_points", mine->to, fields);
    check_mapping_field(context, section, "cells", mapping.conservative ? mine->to : mine->from,
                        fields);
    if (mine->transform != Transform::identity || mine->shape.size() > 2) {
      context.problems.add(
          context.scope.at(*node), fmt::format("field '{}' cannot be mapped", mine->name),
          "a mapped field has the shape [points] or [points, components], and no transform");
    }
    for (const Field& points : fields) {
      if (points.name != mapping.to_points || mine->received_shape.empty()) continue;
      mine->received_shape[0] = points.shape[0];
    }
    check_mapped_shapes(context, *node, *mine, mapping, fields);
    mine->mapping = std::move(mapping);
  }
}

Field read_field(const Context& context, const Declared& declared, const Order& order,
                 const Recorded& recorded) {
  const Section section(*declared.node, object("field"), context.scope);
  Field field;
  field.name = declared.name;
  field.place = declared.place;
  field.unit = section.text("unit", "1");
  field.from = section.text("from");
  field.to = section.text("to");
  field.recorded = recorded.all || recorded.names.contains(field.name);
  field.watched = !section.find("watched") || section.toggle("watched");
  check_end(context, section, "from", declared, order);
  check_end(context, section, "to", declared, order);
  if (!field.from.empty() && field.from == field.to) {
    context.problems.add(section.place("to"),
                         fmt::format("field '{}' goes from '{}' to itself", field.name, field.to),
                         "remove 'to' to record it only");
  }
  if (const Node* shape = section.find("shape")) {
    if (const auto lengths = context.scope.silent().shape(*shape)) {
      field.shape = lengths->lengths;
      field.variable = lengths->variable;
    }
  }
  read_transform(context, section, declared, field);
  if (const Node* initial = section.find("initial")) {
    if (const auto value = context.scope.silent().measured(*initial)) {
      field.initial = value->si;
      if (!value->bare && Unit::valid(field.unit) && !Unit::convertible(value->unit, field.unit)) {
        context.problems.add(context.scope.at(*initial),
                             fmt::format("unit '{}' does not fit {}", value->unit, field.unit),
                             fmt::format("'{}' is in {}", field.name, field.unit));
      }
    }
  }
  return field;
}

/// Names that other fields' mappings use: such a field is sent although nobody receives it.
std::set<std::string> used_by_mappings(const Node& fields) {
  std::set<std::string> names;
  for (const Node& field : fields.items) {
    const Node* mapping = field.kind == Node::Kind::map ? field.find("mapping") : nullptr;
    if (!mapping || mapping->kind != Node::Kind::map) continue;
    for (const char* key : {"from_points", "to_points", "cells"}) {
      if (const Node* name = mapping->find(key)) names.insert(name->text);
    }
  }
  return names;
}

/// Names that the engine itself looks at: whether nothing happens any more, and whether the
/// coupling makes energy.
std::set<std::string> used_by_watches(const Section& section) {
  const auto inside = [&](const char* key, const char* name) -> const Node* {
    const Node* node = section.find(key);
    return node && node->kind == Node::Kind::map ? node->find(name) : nullptr;
  };
  std::set<std::string> names;
  if (const Node* field = inside("rest", "field")) names.insert(field->text);
  if (const Node* energy = inside("stability", "energy")) {
    for (const Node& item : energy->items) names.insert(item.text);
  }
  return names;
}

void read_fields(const Context& context, const Section& section, const Order& order,
                 Coupling& coupling) {
  const Node* map = section.find("fields");
  if (!map || map->kind != Node::Kind::map) return;
  std::vector<std::string> names;
  for (const Node::Key& key : map->keys) names.push_back(key.text);
  const Recorded recorded = read_record(context, names);
  std::set<std::string> used = used_by_mappings(*map);
  used.merge(used_by_watches(section));
  for (size_t i = 0; i < map->keys.size(); ++i) {
    if (map->items[i].kind != Node::Kind::map) continue;
    const Declared declared{names[i], context.scope.at(map->keys[i]), &map->items[i]};
    Field field = read_field(context, declared, order, recorded);
    if (!applies(*declared.node, context.scope) || !contains(order.running, field.from)) continue;
    if (!contains(order.running, field.to)) field.to.clear();
    const bool put_back = context.puts_back(field.name) || used.contains(field.name);
    if (field.to.empty() && !field.recorded && !put_back) {
      coupling.fields_left_out.push_back(field.name);
    } else {
      coupling.fields.push_back(std::move(field));
    }
  }
  read_mappings(context, *map, coupling.fields);
}

Scheme scheme_of(const std::string& name) {
  if (name == "parallel-explicit") return Scheme::parallel_explicit;
  return name == "serial-implicit" ? Scheme::serial_implicit : Scheme::serial_explicit;
}

Acceleration acceleration_of(const std::string& name) {
  if (name == "constant") return Acceleration::constant;
  if (name == "iqn-ils") return Acceleration::iqn_ils;
  return name == "aitken" ? Acceleration::aitken : Acceleration::none;
}

void read_scheme(const Context& context, const Section& section, Coupling& coupling) {
  coupling.scheme = scheme_of(section.text("scheme"));
  coupling.acceleration = acceleration_of(section.text("acceleration"));
  if (coupling.acceleration != Acceleration::none) {
    coupling.relaxation = section.number("relaxation", 0.5);
  }
  coupling.tolerance = section.number("tolerance", coupling.tolerance);
  coupling.iterations = section.count("iterations", coupling.iterations);
  coupling.reused_windows = section.count("reused_windows", coupling.reused_windows);
  coupling.filter = section.number("filter", coupling.filter);
  const bool iterates = coupling.acceleration == Acceleration::aitken ||
                        coupling.acceleration == Acceleration::iqn_ils;
  if (iterates && coupling.scheme != Scheme::serial_implicit) {
    context.problems.add(
        section.place("acceleration"),
        fmt::format("{} needs iterations within a window",
                    coupling.acceleration == Acceleration::aitken ? "Aitken's factor" : "IQN-ILS"),
        "use scheme serial-implicit, or acceleration constant");
  }
  const Node* stability = section.find("stability");
  if (!stability || stability->kind != Node::Kind::map) return;
  const Section limits(*stability, object("stability"), context.scope);
  if (limits.find("watch")) coupling.stability.active = limits.toggle("watch");
  coupling.stability.growth = limits.number("growth", coupling.stability.growth);
  constexpr double more = 0.02;  // some physics grows too
  coupling.stability.monotone_growth =
      limits.number("monotone_growth", coupling.stability.growth + more);
}

void read_rest(const Context& context, const Section& section, Coupling& coupling) {
  const Node* rest = section.find("rest");
  if (!rest || rest->kind != Node::Kind::map || coupling.window <= 0) return;
  const Section limits(*rest, object("rest"), context.scope);
  const std::string field = limits.text("field");
  if (field.empty()) return;
  const std::vector<std::string> names = names_of(coupling.fields);
  if (!contains(names, field)) {
    context.problems.unknown(limits.place("field"), "there is no field", field, names);
    return;
  }
  const double windows = std::ceil(limits.number("for", 0) / coupling.window * (1 - 1e-9));
  coupling.rest = {field, limits.number("at_most", 0),
                   static_cast<std::int64_t>(std::min(windows, 1e9))};
}

/// Which fields hold the energy that the coupling must not make.
void read_energy(const Context& context, const Section& section, Coupling& coupling) {
  const Node* stability = section.find("stability");
  if (!stability || stability->kind != Node::Kind::map) return;
  const Section limits(*stability, object("stability"), context.scope);
  coupling.energy.growth = limits.number("energy_growth", coupling.energy.growth);
  coupling.energy.fields = limits.texts("energy");
  const std::vector<std::string> names = names_of(coupling.fields);
  for (const std::string& name : coupling.energy.fields) {
    if (contains(names, name)) continue;
    context.problems.unknown(limits.place("energy"), "there is no field", name, names);
  }
}

/// Which fields are the unknowns of the iteration: those named, else those that go back to a
/// participant that has run already.
void mark_relaxed(const Context& context, const Section& section, const Order& order,
                  Coupling& coupling) {
  const bool needed =
      coupling.scheme == Scheme::serial_implicit || coupling.acceleration != Acceleration::none;
  const std::vector<std::string> named = section.texts("relax");
  const std::vector<std::string> names = names_of(coupling.fields);
  for (const std::string& name : named) {
    if (contains(names, name)) continue;
    context.problems.unknown(section.place("relax"), "there is no field", name, names);
  }
  if (!needed) return;
  bool any = false;
  const auto position = [&](const std::string& name) {
    return std::find(order.running.begin(), order.running.end(), name);
  };
  for (Field& field : coupling.fields) {
    if (field.to.empty()) continue;
    field.relaxed = section.find("relax") ? contains(named, field.name)
                                          : position(field.to) < position(field.from);
    any = any || field.relaxed;
  }
  if (!any && !coupling.fields.empty()) {
    context.problems.add(section.place("scheme"), "there is no field to iterate on or to relax",
                         "name one under 'relax', or use an explicit scheme without acceleration");
  }
}

}  // namespace

void read_coupling(const Context& context, Workflow& workflow) {
  const Node* node = context.root.find("coupling");
  if (!node || node->kind != Node::Kind::map) return;
  const Section section(*node, object("coupling"), context.scope);
  Coupling coupling;
  coupling.place = context.scope.at(*node);
  read_scheme(context, section, coupling);
  coupling.transport = section.text("exchange") == "file" ? Transport::file : Transport::mapped;
  read_windows(context, section, coupling);
  const Order order = read_order(context, section, workflow);
  if (section.find("order") && order.written.empty()) {
    context.problems.add(section.place("order"), "the order is empty", "name the participants");
  } else if (!order.written.empty() && order.running.empty() && !workflow.participants.empty()) {
    context.problems.add(section.place("order"), "no participant of the order takes part",
                         "check their 'when'");
  }
  coupling.order = order.running;
  read_fields(context, section, order, coupling);
  read_checkpoints(context, coupling);
  mark_relaxed(context, section, order, coupling);
  read_energy(context, section, coupling);
  read_rest(context, section, coupling);
  workflow.coupling = std::move(coupling);
}

}  // namespace sandglass::workflow
