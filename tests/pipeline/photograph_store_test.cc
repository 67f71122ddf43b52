#include "pipeline/photograph_store.h"

#include <filesystem>
#include <random>

#include <gtest/gtest.h>

#include "lightfield/image_io.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

Image<Rgb8> RandomCodes(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image<Rgb8> codes(width, height);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const auto code = [&] { return static_cast<std::uint8_t>(random() & 255U); };
    codes.data()[i] = {code(), code(), code()};
  }
  return codes;
}

void ExpectSame(const PhotographStore& store, const std::filesystem::path& file,
                const Image<Rgb8>& codes) {
  const Image<Rgb8> read = store.Codes(file);
  const Image<Rgb> linear = store.Linear(file), decoded = ReadImage(file);
  ASSERT_EQ(read.size(), codes.size());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    EXPECT_EQ(read.data()[i], codes.data()[i]);
    EXPECT_EQ(linear.data()[i], decoded.data()[i]);
  }
}

TEST(PhotographStore, GivesWhatTheFileWould) {
  const std::filesystem::path folder = ScratchFolder();
  const std::filesystem::path first = folder / "first.png", second = folder / "second.png";
  const Image<Rgb8> a = RandomCodes(31, 17, 1), b = RandomCodes(8, 9, 2);
  WriteCodes8(first, a.span());
  WriteCodes8(second, b.span());
  PhotographStore store(a.size() * sizeof(Rgb8));
  store.Add(first, a.Clone());
  store.Add(second, b.Clone());  // no room
  ExpectSame(store, first, a);
  ExpectSame(store, second, b);
  std::filesystem::remove(first);
  std::filesystem::remove(second);
  EXPECT_NO_THROW(store.Codes(first));
  EXPECT_ANY_THROW(store.Codes(second));
}

TEST(PhotographStore, KnowsAFileByAnyOfItsNames) {
  const Image<Rgb8> codes = RandomCodes(4, 3, 4);
  PhotographStore store(1000);
  store.Add("W/./poses/a.png", codes.Clone());  // which is nowhere: the store has it
  EXPECT_EQ(store.Codes(std::filesystem::absolute("W/poses/a.png")).data()[5], codes.data()[5]);
  EXPECT_NO_THROW(store.Linear("W/depth/../poses/a.png"));
}

TEST(PhotographStore, KeepsNothingWhereItMayNot) {
  const std::filesystem::path folder = ScratchFolder();
  PhotographStore store(0);
  store.Add(folder / "a.png", RandomCodes(2, 2, 3));
  EXPECT_ANY_THROW(store.Codes(folder / "a.png"));
}

}  // namespace
}  // namespace lamella
