#include "lightfield/options.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using testing::HasSubstr;

struct Sample {
  bool fast = true;
  int labels = 96;
  double step_px = 0.0625;
  std::string mode = "cross";
  std::optional<double> range_mm;
};

OptionTable Describe(Sample& s) {
  return {"depth",
          {{"fast", "skip what is slow", &s.fast},
           {"labels", "number of hypotheses", &s.labels, 8, 1024},
           {"step_px", "label step, px", &s.step_px, 0, 10},
           {"mode", "which sources", &s.mode, 0, 0, {"cross", "star"}},
           {"range_mm", "range, mm", &s.range_mm, 0, 100, {}, "--range"}}};
}

std::filesystem::path FileWith(const std::string& text) {
  auto path = ScratchFolder() / "options_test.toml";
  std::ofstream(path) << text;
  return path;
}

std::string ErrorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    return error.what();
  }
  return "no error";
}

TEST(Options, WriteAndReadBackToTheSameValues) {
  Sample a;
  a.fast = false;
  a.labels = 17;
  a.step_px = 0.1;
  a.mode = "star";
  a.range_mm = 1.0 / 3;
  Sample b;
  ApplyToml(FileWith(ToToml({Describe(a)})), {Describe(b)});
  EXPECT_EQ(ToToml({Describe(a)}), ToToml({Describe(b)}));
  EXPECT_EQ(b.range_mm, a.range_mm);
}

TEST(Options, UnsetOptionalIsWrittenAsAComment) {
  Sample a;
  EXPECT_THAT(ToToml({Describe(a)}), HasSubstr("# range_mm is not set"));
}

TEST(Options, NameTheFlagAfterSectionAndNameUnlessGiven) {
  Sample s;
  const OptionTable table = Describe(s);
  EXPECT_EQ(FlagOf(table, table.fields[2]), "--depth-step-px");
  EXPECT_EQ(FlagOf(table, table.fields[4]), "--range");
}

TEST(Options, RefuseAnUnknownKeyWithFileLineAndNearestName) {
  Sample s;
  const std::string line =
      ErrorOf([&] { ApplyToml(FileWith("[depth]\nfast = true\nlabel = 3\n"), {Describe(s)}); });
  EXPECT_THAT(line, HasSubstr("options_test.toml:3"));
  EXPECT_THAT(line, HasSubstr("did you mean \"labels\""));
}

TEST(Options, RefuseWrongTypesRangesAndBrokenToml) {
  Sample s;
  for (const char* text :
       {"[depth]\nlabels = 9000\n", "[depth]\nlabels = 9.5\n", "[depth]\nlabels = \"9\"\n",
        "[depth]\nfast = 1\n", "[depth]\nmode = \"crss\"\n", "[depth]\nstep_px = nan\n",
        "[dpth]\nlabels = 9\n", "depth = 3\n", "[depth\n"}) {
    EXPECT_THAT(ErrorOf([&] { ApplyToml(FileWith(text), {Describe(s)}); }),
                HasSubstr("options_test.toml:"))
        << text;
  }
}

TEST(Options, SetFromTextLikeTheCommandLine) {
  Sample s;
  const OptionTable table = Describe(s);
  SetOption(table.fields[1], "64", "--depth-labels");
  SetOption(table.fields[4], "2.5", "--range");
  EXPECT_EQ(s.labels, 64);
  EXPECT_EQ(s.range_mm, 2.5);
  for (const char* text : {"", "x", "1e999", "12x", "-1"}) {
    EXPECT_THAT(ErrorOf([&] { SetOption(table.fields[1], text, "--depth-labels"); }),
                HasSubstr("--depth-labels"))
        << text;
  }
}

}  // namespace
}  // namespace lamella
