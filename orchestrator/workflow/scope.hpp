#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "workflow/keys.hpp"
#include "workflow/model.hpp"
#include "workflow/problems.hpp"
#include "workflow/yaml.hpp"

namespace sandglass::workflow {

/// A number as it was written: SI value and unit (empty when none was written).
struct Measured {
  double si = 0;
  std::string unit;
  bool bare = true;  ///< no unit was written: fits every unit
};

/// What a `given` holds under one name, resolved.
struct Literal {
  Value value;
  std::optional<FileReference> file;
};

/// Of one field, on either side of its way.
inline constexpr std::int64_t most_field_values = std::int64_t{1} << 31U;

struct FieldShape {
  std::vector<std::int64_t> lengths;
  bool variable = false;
};

/// Reads typed values where parameters may be referred to. Every reader returns nothing when the
/// node does not hold what is wanted, and reports it unless the scope is silent: the structural
/// check reads everything once aloud, the model is then built in silence.
class Scope {
 public:
  Scope(std::string file, const std::vector<Parameter>& parameters, Problems* problems)
      : file_(std::move(file)), parameters_(&parameters), problems_(problems) {}

  /// The same without a voice.
  [[nodiscard]] Scope silent() const;
  /// The same with a choice parameter set to another of its choices.
  [[nodiscard]] Scope assuming(const std::string& parameter, const std::string& choice) const;

  [[nodiscard]] Place at(const Node& node) const { return {file_, node.line, node.column}; }
  [[nodiscard]] Place at(const Node::Key& key) const { return {file_, key.line, key.column}; }
  void report(Place place, std::string what, std::string remedy = {}) const;
  void unknown(Place place, const std::string& what, const std::string& name,
               const std::vector<std::string>& candidates) const;

  [[nodiscard]] const Parameter* parameter(const std::string& name) const;
  [[nodiscard]] std::vector<std::string> parameter_names() const;
  /// The parameter's value here, what is assumed included.
  [[nodiscard]] Value value_of(const Parameter& parameter) const;
  /// The parameter of that name; reported when there is none.
  [[nodiscard]] const Parameter* wanted(Place place, const std::string& name) const;

  /// What stands at a key with a scalar: number (SI), count, switch, or text.
  [[nodiscard]] std::optional<Value> scalar(const Node& node, const Key& key) const;
  /// A number whose unit is not fixed by the table.
  [[nodiscard]] std::optional<Measured> measured(const Node& node) const;
  /// A value typed by how it is written: `$parameter`, number, switch, text, list, map, file.
  [[nodiscard]] std::optional<Literal> literal(const Node& node) const;
  [[nodiscard]] std::optional<FieldShape> shape(const Node& node) const;
  /// Whether every parameter named has (one of) the value(s) given.
  [[nodiscard]] bool holds(const Node& condition) const;

 private:
  [[nodiscard]] std::optional<Value> referred(const Node& node, const Key& key) const;
  [[nodiscard]] std::optional<Value> written(const Node& node, const Key& key) const;
  [[nodiscard]] std::optional<Literal> file_literal(const Node& node) const;
  [[nodiscard]] bool one_holds(const Node::Key& name, const Node& wanted_values) const;

  std::string file_;
  const std::vector<Parameter>* parameters_;
  Problems* problems_;
  std::map<std::string, std::string> assumed_;  ///< choice of a parameter
};

}  // namespace sandglass::workflow
