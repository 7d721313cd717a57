#include <fmt/format.h>

#include <stdexcept>

#include "workflow/documents.hpp"
#include "workflow/keys.hpp"

namespace sandglass::workflow {
namespace {

constexpr const char* begin_marker =
    "<!-- reference: generated from orchestrator/workflow/keys.cpp -->\n";
constexpr const char* end_marker = "<!-- end of reference -->\n";

/// A table cell: bars would end it.
std::string cell(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '|') result += '\\';
    result += c;
  }
  return result;
}

std::string heading_of(const Object& table) {
  for (const Object& other : objects()) {
    for (const Key& key : other.keys) {
      if (key.object != table.name || key.partial) continue;
      const char* many = key.many == Many::map    ? ", by name"
                         : key.many == Many::list ? ", a list"
                                                  : "";
      return fmt::format("`{}` of a {}{}", key.name, other.name, many);
    }
  }
  return "the file";
}

std::string row(const Key& key) {
  std::string meaning = key.doc;
  if (key.required) meaning += " **Required.**";
  if (!key.fallback.empty()) meaning += fmt::format(" Otherwise: {}.", key.fallback);
  return fmt::format("| `{}` | {} | {} | `{}` |\n", key.name, cell(description_of(key)),
                     cell(meaning), cell(key.example));
}

}  // namespace

std::string reference_page() {
  std::string page;
  for (const Object& table : objects()) {
    page += fmt::format("### {} ({})\n\n{}\n\n", table.name, heading_of(table), table.doc);
    page += "| key | value | meaning | example |\n| --- | --- | --- | --- |\n";
    for (const Key& key : table.keys) page += row(key);
    page += "\n";
  }
  return page;
}

std::string with_reference_page(const std::string& readme) {
  const std::string begin = begin_marker;
  const size_t from = readme.find(begin);
  const size_t to = readme.find(end_marker);
  if (from == std::string::npos || to == std::string::npos || to < from) {
    throw std::invalid_argument("workflows/README.md has lost the markers of its generated part");
  }
  return readme.substr(0, from) + begin + "\n" + reference_page() + readme.substr(to);
}

}  // namespace sandglass::workflow
