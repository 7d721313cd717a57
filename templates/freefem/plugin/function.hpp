#pragma once

// FreeFEM's headers do not stand alone: this is the order in which they fit together.
#include <AFunction.hpp>
#include <InitFunct.hpp>
#include <RNM.hpp>
#include <array>
#include <cstdlib>
#include <error.hpp>
#include <iostream>
#include <memory>
#include <string>
#include <utility>

#include "participant.hpp"

/// C++ functions as FreeFEM functions, and how their errors end a script.
namespace sandglass::freefem {

/// A C++ function `Result f(Stack, Arguments...)` as a FreeFEM function. What it throws becomes an
/// error of the script, which FreeFEM reports with the script's line.
template <class Result, class... Arguments>
class Function : public OneOperator {
 public:
  using Body = Result (*)(Stack, Arguments...);
  explicit Function(Body body)
      : OneOperator(map_type[typeid(Result).name()], map_type[typeid(Arguments).name()]...),
        body_(body) {}

  E_F0* code(const basicAC_F0& arguments) const override {
    return cast(arguments, std::index_sequence_for<Arguments...>());
  }

 private:
  using Expressions = std::array<Expression, sizeof...(Arguments)>;

  /// E_F0mps: evaluated every time, never taken for a constant.
  class Call : public E_F0mps {
   public:
    Call(Body body, Expressions arguments) : body_(body), arguments_(arguments) {}
    AnyType operator()(Stack stack) const override {
      return evaluate(stack, std::index_sequence_for<Arguments...>());
    }

   private:
    template <std::size_t... I>
    AnyType evaluate(Stack stack, std::index_sequence<I...>) const {
      try {
        return SetAny<Result>(body_(stack, GetAny<Arguments>((*arguments_[I])(stack))...));
      } catch (const std::exception& error) {
        throw ErrorExec(error.what(), 1);
      }
    }
    Body body_;
    Expressions arguments_;
  };

  template <std::size_t... I>
  E_F0* cast(const basicAC_F0& arguments, std::index_sequence<I...>) const {
    return new Call(body_, Expressions{t[I]->CastTo(arguments[I])...});
  }
  Body body_;
};

template <class Result, class... Arguments>
void add(const char* name, Result (*body)(Stack, Arguments...)) {
  Global.Add(name, "(", new Function<Result, Arguments...>(body));
}

inline string* text(Stack stack, const std::string& value) {
  return Add2StackOfPtr2Free(stack, new string(value));
}

inline Participant& participant() {
  static const std::unique_ptr<Participant> instance = Participant::from_environment();
  return *instance;
}

/// Ends the process, as FreeFEM ends after an error. Not by an exception: FreeFEM unwinds a loop by
/// deleting the variables of its body once more, and crashes on those not yet set in this turn.
[[noreturn]] inline void end(int status) {
  std::cout.flush();
  std::_Exit(status);
}

[[noreturn]] inline void end_with_error(const std::string& why) {
  std::cout << "sandglass: " << why << " (line " << TheCurrentLine << ")" << std::endl;
  end(8);
}

/// What goes wrong in the protocol ends the script, and the orchestrator is told why.
template <class Action>
auto telling(const Action& action) {
  try {
    return action();
  } catch (const std::exception& error) {
    participant().fail(error.what());
    end_with_error(error.what());
  }
}

/// The same for what a script does wrong outside the protocol: the orchestrator is told where there
/// is one.
template <class Action>
auto telling_anybody(const Action& action) {
  try {
    return action();
  } catch (const std::exception& error) {
    if (std::getenv("SANDGLASS_REPLIES") != nullptr) participant().fail(error.what());
    end_with_error(error.what());
  }
}

}  // namespace sandglass::freefem
