#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace sandglass {

/// A typed value that a template may use. Numbers are SI. Values are data: the renderer quotes them
/// for the language they go into, so that no value ever becomes code.
class Value {
 public:
  struct Choice {
    std::string name;                  ///< the chosen name
    std::vector<std::string> choices;  ///< all names it was chosen from
  };
  struct Markup {
    std::string text;  ///< HTML that this program made itself; only an HTML template accepts it
  };
  using List = std::vector<Value>;
  using Map = std::map<std::string, Value>;

  Value() = default;  ///< absent: false in a section, an error where text is wanted
  Value(double number) : data_(number) {}
  Value(std::int64_t number) : data_(number) {}
  Value(int number) : data_(static_cast<std::int64_t>(number)) {}
  Value(bool flag) : data_(flag) {}
  Value(std::string text) : data_(std::move(text)) {}
  Value(const char* text) : data_(std::string(text)) {}
  Value(Choice choice) : data_(std::move(choice)) {}
  Value(Markup markup) : data_(std::move(markup)) {}
  Value(List list) : data_(std::make_shared<List>(std::move(list))) {}
  Value(Map map) : data_(std::make_shared<Map>(std::move(map))) {}

  template <typename T>
  [[nodiscard]] const T* as() const {
    if constexpr (std::is_same_v<T, List> || std::is_same_v<T, Map>) {
      const auto* shared = std::get_if<std::shared_ptr<T>>(&data_);
      return shared ? shared->get() : nullptr;
    } else {
      return std::get_if<T>(&data_);
    }
  }
  [[nodiscard]] bool absent() const { return std::holds_alternative<std::monostate>(data_); }
  /// "number", "count", "switch", "text", "choice", "markup", "list", "map", "nothing"
  [[nodiscard]] std::string type_name() const;

 private:
  std::variant<std::monostate, double, std::int64_t, bool, std::string, Choice, Markup,
               std::shared_ptr<List>, std::shared_ptr<Map>>
      data_;
};

}  // namespace sandglass
