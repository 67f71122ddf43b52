// Quilts of folders and back. The quilts of a real capture and of numbered tiles are made where
// LAMELLA_DATA names the folder of test data.
#include "pipeline/make_quilt.h"

#include <cmath>
#include <cstdlib>
#include <functional>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/image_folder.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;

bool Equal(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b) {
  if (a.width != b.width || a.height != b.height) return false;
  for (int y = 0; y < a.height; ++y) {
    if (!std::equal(a.row(y), a.row(y) + a.width, b.row(y))) return false;
  }
  return true;
}

// Mean over every `step`-th row.
double MeanSquare(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b, int step = 1) {
  double sum = 0;
  int rows = 0;
  for (int y = 0; y < a.height; y += step, ++rows) {
    for (int x = 0; x < a.width; ++x) {
      const Rgb8 p = a(x, y), q = b(x, y);
      const int r = p.r - q.r, g = p.g - q.g, bl = p.b - q.b;
      sum += r * r + g * g + bl * bl;
    }
  }
  return sum / (3.0 * a.width * rows);
}

// Pictures of 4 x 3 px with codes by their place in the order.
fs::path FolderOf(const std::vector<std::string>& names) {
  fs::path folder = ScratchFolder() / "views";
  fs::create_directory(folder);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto code = static_cast<std::uint8_t>(10 * (i + 1));
    WriteCodes8(folder / names[i], Image<Rgb8>(4, 3, {code, 5, 7}).span());
  }
  return folder;
}

std::string ErrorOf(const std::function<void()>& action, ExitCode code) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "no error";
}

void ExpectHas(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST(MakeQuilt, TakesNamesByTheirNumbersAndReadsBack) {
  const fs::path folder = FolderOf({"v1.png", "v2.png", "v9.png", "v010.png", "v11.png"});
  const MadeQuilt made =
      MakeQuilt(folder, {{3, 2, 0.75}, false}, folder / "../out", SilentProgress());
  EXPECT_EQ(made.file.filename(), "views_qs3x2a0.75.png");
  EXPECT_EQ(made.views, 5);
  const ReadQuiltResult read = ReadQuilt(made.file, {});
  EXPECT_EQ(read.views, 5);
  EXPECT_EQ(read.layout.columns, 3);
  EXPECT_EQ(read.layout.rows, 2);
  EXPECT_EQ(read.codes(0, 5).r, 10);   // bottom left
  EXPECT_EQ(read.codes(11, 5).r, 30);  // bottom right
  EXPECT_EQ(read.codes(0, 0).r, 40);   // "010" is ten
  EXPECT_EQ(read.codes(11, 0), (Rgb8{0, 0, 0}));
  const auto files = SplitQuilt(made.file, {}, folder / "../back", SilentProgress());
  ASSERT_EQ(files.size(), 5U);
  EXPECT_EQ(files[3].filename(), "view_003.png");
  const MadeQuilt again = MakeQuilt(folder / "../back", {{3, 2, 0.75}, false},
                                    folder / "../again.png", SilentProgress());
  EXPECT_EQ(again.file.filename(), "again_qs3x2a0.75.png");
  EXPECT_TRUE(Equal(ReadSrgb8(again.file).span(), read.codes.span()));
}

TEST(MakeQuilt, TurnsTheOrderRoundAndTakesTheViewsAspect) {
  const fs::path folder = FolderOf({"a.png", "b.png"});
  const MadeQuilt made =
      MakeQuilt(folder, {{2, 1, {}}, true}, folder / "../x.png", SilentProgress());
  EXPECT_EQ(made.file.filename(), "x_qs2x1a1.3333.png");
  const Image<Rgb8> codes = ReadSrgb8(made.file);
  EXPECT_EQ(codes(0, 0).r, 20);
  EXPECT_EQ(codes(7, 0).r, 10);
}

TEST(MakeQuilt, MistakesAreOneLine) {
  const fs::path folder = FolderOf({"a.png", "b.png", "c.png"});
  const auto make = [&](QuiltLayout layout, const fs::path& out) {
    return [=] { MakeQuilt(folder, {layout, false}, out, SilentProgress()); };
  };
  ExpectHas(ErrorOf(make({2, 1, {}}, folder / "x.png"), ExitCode::kUsage),
            "holds 3 views, and 2 x 1 tiles take 2; give more --columns or --rows");
  ExpectHas(ErrorOf(make({3, 1, {}}, folder / "x.jpg"), ExitCode::kUsage), "is no .png");
  ExpectHas(ErrorOf(make({3, 1, {}}, folder / "x_qs8x6a0.75.png"), ExitCode::kUsage),
            "its name tells another layout than _qs3x1a1.3333");
  ExpectHas(ErrorOf(
                [&] {
                  MakeQuilt(folder / "none", {{3, 1, {}}, false}, folder, SilentProgress());
                },
                ExitCode::kInput),
            "is no file or folder");
  WriteCodes8(folder / "b.png", Image<Rgb8>(4, 4).span());
  ExpectHas(ErrorOf(make({3, 1, {}}, folder / "x.png"), ExitCode::kInput),
            "b.png: has 4 x 4 px, and a.png has 4 x 3; make all views alike in size");
  EXPECT_FALSE(fs::exists(folder / "x_qs3x1a1.3333.png"));
}

TEST(ReadQuilt, MistakesAreOneLine) {
  const fs::path folder = ScratchFolder();
  WriteCodes8(folder / "plain.png", Image<Rgb8>(8, 6, {9, 9, 9}).span());
  WriteCodes8(folder / "black_qs2x2a1.png", Image<Rgb8>(8, 6).span());
  const auto read = [&](const char* name, const ReadQuiltOptions& options) {
    return [=] { ReadQuilt(folder / name, options); };
  };
  ExpectHas(ErrorOf(read("plain.png", {}), ExitCode::kUsage),
            "its name has no layout like _qs8x6a0.75; give --columns and --rows");
  ExpectHas(ErrorOf(read("plain.png", {9, 1, {}, 0}), ExitCode::kInput),
            "has 8 x 6 px, too few for 9 x 1 tiles");
  ExpectHas(ErrorOf(read("black_qs2x2a1.png", {}), ExitCode::kInput), "is black");
  ExpectHas(ErrorOf(read("black_qs2x2a1.png", {0, 0, {}, 5}), ExitCode::kUsage),
            "2 x 2 tiles hold no 5 views");
  EXPECT_EQ(ReadQuilt(folder / "black_qs2x2a1.png", {0, 0, {}, 4}).views, 4);
  EXPECT_EQ(ReadQuilt(folder / "plain.png", {4, 3, {}, 0}).views, 12);
}

fs::path RealPhotographs() {
  const char* place = std::getenv("LAMELLA_DATA");
  return place == nullptr ? fs::path() : fs::path(place);
}

TEST(RealQuilt, IsThatOfItsPhotographsAndReadsBackToThem) {
  if (RealPhotographs().empty()) GTEST_SKIP() << "LAMELLA_DATA is not set";
  const fs::path photos = RealPhotographs() / "greenbuddha/images", scratch = ScratchFolder();
  const MadeQuilt made =
      MakeQuilt(photos, {{7, 5, 0.5625}, false}, scratch / "GreenBuddha.png", SilentProgress());
  const fs::path published_file = RealPhotographs() / "greenbuddha/GreenBuddha_qs7x5a0.5625.jpg";
  EXPECT_EQ(made.file.stem(), published_file.stem());
  const ReadQuiltResult ours = ReadQuilt(made.file, {}), published = ReadQuilt(published_file, {});
  EXPECT_EQ(ours.codes.width(), published.codes.width());
  EXPECT_EQ(ours.codes.height(), published.codes.height());
  EXPECT_EQ(ours.views, 33);
  EXPECT_EQ(published.views, 33);
  const std::vector<NamedFile> files = ImagesOf(photos);
  ASSERT_EQ(files.size(), 33U);
  std::vector<Image<Rgb8>> pictures;
  for (const NamedFile& file : files) pictures.push_back(ReadSrgb8(file.path));
  double error = 0;
  for (int view = 0; view < 33; ++view) {
    const auto photo = pictures[static_cast<std::size_t>(view)].span();
    EXPECT_TRUE(Equal(QuiltView(ours.codes.span(), ours.layout, view), photo)) << view;
    // The published tile is this photograph's and no other's.
    const auto tile = QuiltView(published.codes.span(), published.layout, view);
    const double own = MeanSquare(tile, photo);
    error += own / 33;
    for (int other = 0; other < 33; ++other) {
      if (other == view) continue;
      EXPECT_LT(2 * own, MeanSquare(tile, pictures[static_cast<std::size_t>(other)].span(), 8));
    }
  }
  const double psnr = 10 * std::log10(255.0 * 255.0 / error);
  RecordProperty("psnr_db", fmt::format("{:.2f}", psnr));
  EXPECT_NEAR(psnr, 36.9, 0.1);
  for (const int view : {33, 34}) {
    const auto tile = QuiltView(published.codes.span(), published.layout, view);
    const Image<Rgb8> black(tile.width, tile.height);
    EXPECT_TRUE(Equal(QuiltView(ours.codes.span(), ours.layout, view), black.span()));
    EXPECT_LT(MeanSquare(tile, black.span()), 1);
  }
  const auto back = SplitQuilt(made.file, {}, scratch / "back", SilentProgress());
  ASSERT_EQ(back.size(), 33U);
  for (std::size_t view = 0; view < 33; ++view) {
    EXPECT_TRUE(Equal(ReadSrgb8(back[view]).span(), pictures[view].span())) << view;
  }
}

TEST(RealQuilt, OfNumbersIsReadAndWoven) {
  if (RealPhotographs().empty()) GTEST_SKIP() << "LAMELLA_DATA is not set";
  const fs::path folder = RealPhotographs() / "formats/lookingglass";
  const ReadQuiltResult read = ReadQuilt(folder / "quilt_numbers_qs8x6.png", {});
  EXPECT_EQ(read.views, 48);
  EXPECT_EQ(QuiltView(read.codes.span(), read.layout, 0).width, 192);
  EXPECT_EQ(QuiltView(read.codes.span(), read.layout, 0).height, 341);
  const NativeImage native =
      MakeNative(folder / "quilt_numbers_qs8x6.png", folder / "visual_LKG-PORT-05935.json", {});
  EXPECT_EQ(native.serial, "LKG-PORT-05935");
  EXPECT_EQ(native.codes.width(), 1536);
  EXPECT_EQ(native.codes.height(), 2048);
}

}  // namespace
}  // namespace lamella
