#pragma once

#include <string>

#include "render/template.hpp"

namespace sandglass::render {

/// Appends quote(value, language) to `out`, without the intermediate text.
void append_quoted(std::string& out, const Value& value, Language language);

/// Appends text as a literal of the language, or throws Error::refused (without a place).
void append_text(std::string& out, const std::string& text, Language language);

}  // namespace sandglass::render
