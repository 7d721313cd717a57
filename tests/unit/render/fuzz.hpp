#pragma once

#include <cstdint>
#include <string>

#include "render/template.hpp"

namespace sandglass {

/// One fuzzing step: any bytes may be a template, and it may end in an Error only. The first byte
/// chooses the language.
inline void fuzz_template(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return;
  const auto language = static_cast<Language>(data[0] % 8);
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const Value::Map item{{"name", "a"}, {"x", 1}};
  const Value::Map values{{"x", 1.5},
                          {"s", true},
                          {"t", "it's"},
                          {"n", Value::List{1, 2}},
                          {"p", Value::List{item, item}},
                          {"m", item},
                          {"c", Value::Choice{"a", {"a", "b"}}},
                          {"nothing", Value()}};
  try {
    const Template made = Template::parse(text, "fuzz.py", language, [&](const std::string& path) {
      return path == "same.py" ? text : std::string("{{#s}}\n {{x}}\n{{/s}}\n");
    });
    (void)made.check(values, {});
    (void)made.render(values);
  } catch (const Error&) {
  }
}

}  // namespace sandglass
