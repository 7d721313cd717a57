#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>

#include "../support/scratch.hpp"
#include "programs.hpp"
#include "template_helpers.hpp"

// A value arrives in the real interpreter as its very text, or is refused; it is never executed.
namespace sandglass {
namespace {

/// Texts that try to make a file "executed", and others that are only hard to write.
std::vector<std::string> hostile_texts() {
  std::vector<std::string> all{
      "'); import os; os.system(\"touch executed\") #",
      "'+__import__('os').system('touch executed')+'",
      "\"+__import__('os').system('touch executed')+\"",
      "{__import__('os').system('touch executed')}",
      "\\'); __import__('os').system('touch executed') #",
      "\n__import__('os').system('touch executed')\n",
      "\r__import__('os').system('touch executed')\r",
      "\u2028__import__('os').system('touch executed')",
      "'''\n__import__('os').system('touch executed')\n'''",
      "\"\"\"\n__import__('os').system('touch executed')\n\"\"\"",
      "coding: utf-7 +AAo-__import__('os').system('touch executed')",
      "coding=utf-7 +AAo-__import__('os').system('touch executed')",
      "\"; exec(\"touch executed\"); //",
      "a\\\"; exec(command); //",
      "a\\\\\"; exec(command); //",
      "ENDIFMACRO exec(command); IFMACRO(unknown)",
      "ENDIFMACRO exec(command); IFMACRO(unknown) ",
      "EndMacro exec(command); NewMacro g(x)",
      "// exec(command);",
      "*/ exec(command); /*",
      "\n exec(command);\n",
      "\"; SystemCall \"touch executed\"; //",
      "'; SystemCall 'touch executed'; //",
      "EndIf SystemCall 'touch executed';",
      "Else SystemCall 'touch executed';",
      "ElseIf(1) SystemCall 'touch executed';",
      "EndFor SystemCall 'touch executed';",
      "Return SystemCall 'touch executed';",
      "a/EndIf1 SystemCall 'touch executed';",
      "*/ SystemCall 'touch executed'; /*",
      "\n SystemCall 'touch executed';\n",
      "$(touch executed)",
      "`touch executed`",
      "'; touch executed; '",
      "\"; touch executed; \"",
      "\\'; touch executed #",
      "{{x}} {{#x}}",
      "plain text",
      "with 'single' quotes",
      "with \"double\" quotes",
      "back\\slash and trailing\\",
      "tab\tand %s %d %n #hash @at $dollar ~",
      "a//b /c//d",
      "http://example.org/?a=b&c=d",
      "é 日本 😀",
      "",
      " ",
      "x y",
  };
  for (const size_t size : {255U, 256U, 511U, 1000U, 1023U, 1024U, 10'000U})
    all.push_back(std::string(size, 'a'));
  all.push_back(std::string(254, 'a') + "//" + std::string(10, '"'));
  for (char c = 1; c < 127; ++c) all.push_back(std::string("a") + c + "b" + c + c);
  return all;
}

struct Interpreter {
  const char* program;
  std::vector<std::string> arguments;  // before the script
  const char* script;                  // its name
  const char* begin;                   // before every script
  const char* arrive;                  // for every item: writes {{x}} into the file {{file}}
  const char* tail;                    // what the interpreter itself writes behind it
  std::vector<const char*> around;     // other code around {{x}}, each good on its own
  const char* end;                     // behind every script: makes the file "ended"
};

void PrintTo(const Interpreter& interpreter, std::ostream* out) { *out << interpreter.program; }

class Hostile : public testing::TestWithParam<Interpreter> {
 protected:
  void SetUp() override {
    const Interpreter& interpreter = GetParam();
    if (!installed(interpreter.program)) GTEST_SKIP() << interpreter.program << " is not installed";
    for (const std::string& text : hostile_texts()) {
      const bool refused =
          !refusal([&] { (void)quote(text, language_of(interpreter.script)); }).empty();
      if (!refused) texts_.push_back(text);
    }
  }

  /// The accepted texts as items; with `files`, each has a file of its own.
  [[nodiscard]] Value::List items(bool files) const {
    Value::List all;
    for (const std::string& text : texts_) {
      Value::Map item{{"x", text}};
      if (files) item["file"] = fmt::format("arrived{}", all.size());
      all.emplace_back(std::move(item));
    }
    return all;
  }

  /// Runs the code for every item in one script; it must come to its end, and nothing else may
  /// have run.
  void run(const std::string& code, const Value::List& items) {
    const Interpreter& interpreter = GetParam();
    const std::string text =
        std::string(interpreter.begin) + "{{#items}}\n" + code + "\n{{/items}}\n" + interpreter.end;
    const std::string script =
        parsed(text, language_of(interpreter.script)).render({{"items", items}});
    write_file(scratch_.file(interpreter.script), script);
    std::vector<std::string> command{interpreter.program};
    command.insert(command.end(), interpreter.arguments.begin(), interpreter.arguments.end());
    command.emplace_back(interpreter.script);
    EXPECT_EQ(run_program(command, scratch_.path()), 0) << script;
    EXPECT_TRUE(std::filesystem::remove(scratch_.file("ended"))) << script;
    EXPECT_FALSE(std::filesystem::remove(scratch_.file("executed"))) << script;
  }

  test::Scratch scratch_;
  std::vector<std::string> texts_;
};

TEST_P(Hostile, TextArrivesAsItIsOrIsRefused) {
  run(GetParam().arrive, items(true));
  for (size_t i = 0; i < texts_.size(); ++i) {
    EXPECT_EQ(read_file(scratch_.file(fmt::format("arrived{}", i))), texts_[i] + GetParam().tail);
  }
  EXPECT_GT(texts_.size(), 100U);  // ordinary texts are not refused wholesale
}

TEST_P(Hostile, NothingIsExecutedWhereverTheValueStands) {
  for (const char* around : GetParam().around) {
    SCOPED_TRACE(around);
    run(around, items(false));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Interpreters, Hostile,
    testing::Values(
        Interpreter{
            "python3",
            {"-I", "-S"},
            "script.py",
            "",
            "open({{file}}, 'w', encoding='utf-8', newline='').write({{x}})",
            "",
            {"# {{x}}", "a = 1  # it's {{x}}", "a = [{{x}}, {{x}}]", "a = 'b' {{x}} 'c'",
             "a = f'' {{x}}", "a = {{x}} 'c'", "if 1:\n  # {{x}}\n  a = {{x}} # {{x}}",
             "a = '' + {{x}}", "a = '\\'' + {{x}}", "a = '''it's''' {{x}}", "a = {'b': {{x}} }"},
            "open('ended', 'w')\n"},
        Interpreter{
            "FreeFem++",
            {"-nw", "-v", "0"},
            "script.edp",
            "string command = \"touch executed\";\n",
            "{ ofstream file({{file}}); file << {{x}}; }",
            "",
            {"// {{x}}", "cout << {{x}} << {{x}};", "{\nmacro f(x) cout << x; // EOM\nf({{x}})\n}",
             "{\nmacro f(x) cout << {{x}} << x; // EOM\nf(1)\n}",
             "{\nmacro f(x) cout << {{x}} << x;\n// EOM\nf(1)\n}",
             "{\nmacro f(x) cout << x; // EOM\nmacro g(x) f(x) // EOM\ng({{x}})\n}",
             "{\nNewMacro f(x) cout << {{x}} << x; EndMacro\nf({{x}})\n}",
             "IFMACRO(unknown)\ncout << {{x}};\nENDIFMACRO",
             "{\nmacro known 3 // EOM\nIFMACRO(known)\ncout << {{x}};\nENDIFMACRO\n}"},
            "{ ofstream file(\"ended\"); }\n"},
        Interpreter{"gmsh",
                    {"-parse_and_exit", "-v", "0"},
                    "script.geo",
                    "",
                    "Printf(Str({{x}})) > {{file}};",
                    "\n",
                    {"// {{x}}", "s = StrCat({{x}}, {{x}});", "If(0)\ns = {{x}};\nEndIf",
                     "If(1)\ns = {{x}};\nEndIf", "If(1)\nElse\ns = {{x}};\nEndIf",
                     "If(0)\nElse\ns = {{x}};\nEndIf", "For i In {1:0}\ns = {{x}};\nEndFor",
                     "For i In {1:2}\ns = {{x}};\nEndFor", "If(0)\n// {{x}}\nEndIf"},
                    "Printf(\"\") > \"ended\";\n"},
        Interpreter{"dash",
                    {},
                    "script.sh",
                    "",
                    "printf %s {{x}} > {{file}}",
                    "",
                    {"# {{x}}", "echo {{x}} a{{x}}b", "echo $(echo {{x}})", "a={{x}}; echo \"$a\"",
                     "cat <<END\nit's\nEND\necho {{x}}", "case {{x}} in a) ;; esac # it's {{x}}"},
                    ": > ended\n"}),
    [](const auto& each) {
      std::string name = each.param.program;
      std::erase_if(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
      return name;
    });

// Python looks for the encoding of a script in the comments of its first two lines.
TEST(HostileFirstLine, DeclaresNoEncoding) {
  if (!installed("python3")) GTEST_SKIP() << "python3 is not installed";
  const test::Scratch scratch;
  for (const char* text : {"coding: utf-7 +AAo-import os; os.system('touch executed')+AAo-",
                           "coding=utf-7 +AAo-import os; os.system('touch executed')+AAo-"}) {
    const std::string script = parsed("# {{x}}\n", Language::python).render({{"x", text}});
    write_file(scratch.file("script.py"), script);
    EXPECT_EQ(run_program({"python3", "-I", "script.py"}, scratch.path()), 0) << script;
    EXPECT_FALSE(std::filesystem::exists(scratch.file("executed"))) << script;
  }
}

TEST(Numbers, ArriveInTheInterpretersAsTheSameDouble) {
  std::vector<double> numbers{
      0.1, 1.0 / 3, 5e-324, 1e22, 1.0, 123456789.12345678, 1.7976931348623157e308};
  for (size_t i = numbers.size(); i > 0; --i) numbers.push_back(-numbers[i - 1]);
  Value::List items;
  for (size_t i = 0; i < numbers.size(); ++i) {
    items.push_back(Value::Map{{"x", numbers[i]}, {"file", fmt::format("arrived{}", i)}});
  }
  struct Script {
    std::vector<std::string> command;
    const char* text;
  };
  const std::vector<Script> scripts{
      {{"python3", "-I", "-S", "script.py"},
       "{{#items}}\nopen({{file}}, 'w').write('%.17g' % (3-{{x}}/2))\n{{/items}}\n"},
      {{"FreeFem++", "-nw", "-v", "0", "script.edp"},
       "{{#items}}\n{ ofstream f({{file}}); f.precision(17); f << 3-{{x}}/2; }\n{{/items}}\n"},
      {{"gmsh", "-parse_and_exit", "-v", "0", "script.geo"},
       "{{#items}}\nPrintf(\"%.17g\", 3-{{x}}/2) > {{file}};\n{{/items}}\n"}};
  for (const Script& each : scripts) {
    if (!installed(each.command.front())) continue;
    const test::Scratch scratch;
    const std::string& file = each.command.back();
    const std::string script = parsed(each.text, language_of(file)).render({{"items", items}});
    write_file(scratch.file(file), script);
    ASSERT_EQ(run_program(each.command, scratch.path()), 0) << script;
    for (size_t i = 0; i < numbers.size(); ++i) {
      const std::string arrived = read_file(scratch.file(fmt::format("arrived{}", i)));
      EXPECT_EQ(std::strtod(arrived.c_str(), nullptr), 3 - numbers[i] / 2) << script;
    }
  }
}

}  // namespace
}  // namespace sandglass
