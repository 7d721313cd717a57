#include "participant/replies.hpp"

#include <algorithm>
#include <sstream>
#include <utility>

namespace sandglass::participant {
namespace {

constexpr const char* kProtocol = "1";
constexpr size_t kLongestLine = 65536;
constexpr size_t kMost = 1000;  // notes, and savings

}  // namespace

std::optional<std::string> Replies::next_answer() {
  size_t begin = 0;
  std::optional<std::string> answer;
  for (size_t end = 0; !answer && (end = unread_.find('\n', begin)) != std::string::npos;
       begin = end + 1) {
    std::string line = unread_.substr(begin, end - begin);
    if (line.starts_with("note ")) {
      if (notes_.size() < kMost) notes_.push_back(line.substr(5));
    } else if (line.starts_with("saved ")) {
      keep_saving(line.substr(6));
    } else {
      answer = std::move(line);
    }
  }
  unread_.erase(0, begin);
  return answer;
}

bool Replies::endless() const { return unread_.size() > kLongestLine; }

void Replies::keep_saving(const std::string& text) {
  std::istringstream words(text);
  Saving saving;
  words >> saving.name >> saving.seconds;
  const auto known = std::find_if(savings_.begin(), savings_.end(),
                                  [&](const Saving& one) { return one.name == saving.name; });
  if (known != savings_.end()) {
    *known = saving;
  } else if (savings_.size() < kMost) {
    savings_.push_back(saving);
  }
}

std::optional<std::set<std::string>> abilities_in(const std::string& ready_line) {
  std::istringstream words(ready_line);
  std::string word;
  std::string version;
  words >> word >> version;
  if (word != "ready" || version != kProtocol) return std::nullopt;
  std::set<std::string> abilities;
  while (words >> word) abilities.insert(word);
  return abilities;
}

}  // namespace sandglass::participant
