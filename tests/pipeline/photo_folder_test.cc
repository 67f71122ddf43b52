#include "pipeline/poses/photo_folder.h"

#include <gtest/gtest.h>

#include "lightfield/image_io.h"
#include "tests/lightfield/raw_image_files.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;

TEST(PhotoFolder, LinksPlainFilesUnderSafeNamesAndConvertsAllOthers) {
  const fs::path folder = ScratchFolder();
  Image<Rgb8> stored(32, 16, {20, 20, 20});
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x) stored(x, y) = {250, 250, 250};
  }
  WriteCodes8(folder / "a b.JPG", stored.span());
  WriteBytes(folder / "turned.jpg", WithExif(ReadBytes(folder / "a b.JPG"), 6, 5, 0));
  WriteBytes(folder / "deep.png", RawPng(1, 1, 3, 16, {257, 514, 65535}));
  CaptureRecord capture;
  for (const char* name : {"a b.JPG", "turned.jpg", "deep.png"}) {
    CapturedView view;
    view.file = folder / name;
    view.is_plain = std::string(name) == "a b.JPG";
    capture.views.push_back(view);
  }
  fs::create_directory(folder / "out");
  const std::vector<std::string> names = MakePhotoFolder(capture, folder / "out", SilentProgress());
  EXPECT_EQ(names, (std::vector<std::string>{"000000.jpg", "000001.png", "000002.png"}));
  EXPECT_TRUE(fs::is_symlink(folder / "out/000000.jpg"));
  EXPECT_EQ(ReadBytes(folder / "out/000000.jpg"), ReadBytes(folder / "a b.JPG"));
  const Image<Rgb8> upright = ReadSrgb8(folder / "out/000001.png");
  EXPECT_EQ(upright.width(), 16);
  EXPECT_GT(upright(12, 4).g, 200);  // the stored top left, turned clockwise
  EXPECT_EQ(ReadImageInfo(folder / "out/000002.png").bits, 8);
  EXPECT_EQ(ReadSrgb8(folder / "out/000002.png")(0, 0), (Rgb8{1, 2, 255}));
}

}  // namespace
}  // namespace lamella
