#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "workflow/documents.hpp"
#include "workflow/keys.hpp"

namespace sandglass::workflow {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* name_pattern = "^[A-Za-z_][A-Za-z0-9_]{0,99}$";
constexpr const char* choice_pattern = "^[A-Za-z0-9_-]{1,100}$";
constexpr const char* reference_pattern = "^\\$[A-Za-z_][A-Za-z0-9_]{0,99}$";

Json defined(const std::string& name) { return {{"$ref", "#/$defs/" + name}}; }

Json scalar() { return {{"type", Json::array({"string", "number", "boolean"})}}; }

/// One or several values, by parameter.
Json condition() {
  const Json list = {{"type", "array"}, {"items", scalar()}};
  return {{"type", "object"},
          {"propertyNames", {{"pattern", name_pattern}}},
          {"additionalProperties", {{"anyOf", Json::array({scalar(), list})}}}};
}

/// One value by parameter, or a list of them.
Json settings(bool sweep) {
  const Json list = {{"type", "array"}, {"minItems", 1}, {"items", scalar()}};
  return {{"type", "object"},
          {"propertyNames", {{"pattern", name_pattern}}},
          {"additionalProperties", sweep ? list : scalar()}};
}

Json given() {
  const Json map = {{"type", "object"}, {"propertyNames", {{"pattern", name_pattern}}}};
  const Json name = {{"type", "string"}, {"pattern", name_pattern}};
  const Json list = {{"type", "array"}, {"items", {{"anyOf", Json::array({name, map})}}}};
  return {{"anyOf", Json::array({list, map})}};
}

Json count() { return {{"type", "integer"}, {"minimum", 0}}; }
Json parameter_reference() { return {{"type", "string"}, {"pattern", reference_pattern}}; }

Json shape() {
  const Json length = {{"anyOf", Json::array({count(), parameter_reference()})}};
  const Json limit = {{"type", "object"},
                      {"properties", {{"at_most", length}}},
                      {"required", Json::array({"at_most"})},
                      {"additionalProperties", false}};
  return {{"type", "array"},
          {"minItems", 1},
          {"maxItems", 8},
          {"items", {{"anyOf", Json::array({count(), parameter_reference(), limit})}}}};
}

Json selection() {
  const Json all = {{"enum", Json::array({"all", "none"})}};
  const Json list = {{"type", "array"}, {"items", {{"type", "string"}, {"pattern", name_pattern}}}};
  return {{"anyOf", Json::array({all, list})}};
}

/// One value at the key, references aside.
Json one(const Key& key) {
  switch (key.kind) {
    case Kind::version:
      return {{"const", format_version}};
    case Kind::text:
    case Kind::unit:
      return scalar();
    case Kind::template_:
      return {{"type", "string"}};
    case Kind::name:
      return {{"type", "string"}, {"pattern", name_pattern}};
    case Kind::choice:
      return {{"enum", key.names}};
    case Kind::toggle:
      return {{"type", "boolean"}};
    case Kind::count:
      return count();
    case Kind::number:
      return {{"type", Json::array({"number", "string"})}};
    case Kind::literal:
      return scalar();
    case Kind::given:
      return given();
    case Kind::condition:
      return condition();
    case Kind::settings:
      return settings(false);
    case Kind::sweep:
      return settings(true);
    case Kind::shape:
      return shape();
    case Kind::selection:
      return selection();
    case Kind::object:
      return defined(key.partial ? key.object + "_case" : key.object);
  }
  return {};
}

Json value(const Key& key) {
  Json result = one(key);
  // A number may be a text already, and a parameter is one.
  const bool alternative = key.reference && key.kind != Kind::number && key.kind != Kind::text;
  if (alternative) result = {{"anyOf", Json::array({result, parameter_reference()})}};
  if (key.many == Many::list) result = {{"type", "array"}, {"items", result}};
  if (key.many == Many::map) {
    result = {{"type", "object"},
              {"propertyNames", {{"pattern", key.partial ? choice_pattern : name_pattern}}},
              {"additionalProperties", result}};
  }
  result["description"] = key.doc;
  return result;
}

Json definition(const Object& table, bool partial) {
  Json properties = Json::object();
  Json required = Json::array();
  for (const Key& key : table.keys) {
    properties[key.name] = value(key);
    if (key.required && !partial) required.push_back(key.name);
  }
  Json result = {{"type", "object"}, {"description", table.doc}, {"properties", properties}};
  if (!required.empty()) result["required"] = required;
  result["additionalProperties"] = false;
  return result;
}

}  // namespace

std::string json_schema() {
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                 {"title", fmt::format("Sandglass workflow, format {}", format_version)}};
  schema.update(definition(objects().front(), false));
  Json definitions = Json::object();
  for (size_t i = 1; i < objects().size(); ++i) {
    const Object& table = objects()[i];
    definitions[table.name] = definition(table, false);
    if (table.find("cases")) definitions[table.name + "_case"] = definition(table, true);
  }
  schema["$defs"] = definitions;
  return schema.dump(2) + "\n";
}

}  // namespace sandglass::workflow
