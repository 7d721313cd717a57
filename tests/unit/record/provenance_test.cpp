#include "record/provenance.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "../support/scratch.hpp"

namespace sandglass::record {
namespace {

using testing::HasSubstr;

// SHA-256 of "abc", from FIPS 180-4's examples.
constexpr const char* kDigestOfAbc =
    "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

TEST(Provenance, AProgramIsIdentifiedWithItsParts) {
  const test::Scratch scratch;
  std::ofstream(scratch.file("part")) << "abc";
  const UsedProgram used =
      identify("shell", "sh", "no-such-package", {scratch.file("part"), scratch.file("none")});
  EXPECT_EQ(used.name, "shell");
  EXPECT_THAT(used.path, testing::EndsWith("/sh"));
  EXPECT_THAT(used.digest, testing::MatchesRegex("[0-9a-f]+"));
  EXPECT_EQ(used.digest.size(), 64U);
  EXPECT_EQ(used.version, "");
  ASSERT_EQ(used.parts.size(), 1U) << "what is not there is passed over";
  EXPECT_EQ(used.parts[0].path, scratch.file("part"));
  EXPECT_EQ(used.parts[0].digest, kDigestOfAbc);
  EXPECT_EQ(to_json(used).at("parts").at(0).at("digest"), kDigestOfAbc);
}

TEST(Provenance, AMissingProgramIsAnEmptyPath) {
  const UsedProgram used = identify("none", "no-such-program-at-all", "no-such-package");
  EXPECT_EQ(used.path, "");
  EXPECT_EQ(used.digest, "");
}

TEST(Provenance, AnInstalledPackageHasItsVersion) {
  // Debian's C library is on every Debian; its name is exact, not a beginning.
  EXPECT_THAT(package_version("libc6"), HasSubstr("2."));
  EXPECT_EQ(package_version("libc"), "");
}

TEST(Provenance, OfTheEnvironmentOnlyWhatCanMatter) {
  ::setenv("OMP_NUM_THREADS", "3", 1);
  ::setenv("SECRET_TOKEN", "do not tell", 1);
  const nlohmann::json environment = describe_environment();
  EXPECT_EQ(environment.at("OMP_NUM_THREADS"), "3");
  EXPECT_FALSE(environment.contains("SECRET_TOKEN"));
  EXPECT_FALSE(environment.contains("HOME"));
  ::unsetenv("OMP_NUM_THREADS");
  ::unsetenv("SECRET_TOKEN");
}

TEST(Provenance, TheMachineIsDescribed) {
  const nlohmann::json machine = describe_machine();
  EXPECT_GE(machine.at("cores"), 1);
  EXPECT_GT(machine.at("memory_bytes"), 1e6);
  EXPECT_FALSE(machine.at("system").get<std::string>().empty());
}

}  // namespace
}  // namespace sandglass::record
