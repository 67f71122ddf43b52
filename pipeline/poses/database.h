// COLMAP's database (SQLite): what its feature extractor wrote, and the cameras that we give it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/poses/model.h"

struct sqlite3;

namespace lamella {

// SIFT descriptors: `count` rows of 128 bytes (L1-root, x512), in the order of the keypoints.
struct Descriptors {
  static constexpr int kLength = 128;
  int count = 0;
  std::vector<std::uint8_t> rows;
};

class ColmapDatabase {
 public:
  // MachineError where the file can't be opened or is no database.
  explicit ColmapDatabase(const std::filesystem::path& file);
  ~ColmapDatabase();
  ColmapDatabase(const ColmapDatabase&) = delete;
  ColmapDatabase& operator=(const ColmapDatabase&) = delete;

  std::map<std::string, std::uint32_t> ImageIds();  // by name
  // Gives the images with features the numbers 1, 2, ... in the order of these names; only before
  // any pairs were matched.
  void NumberImages(const std::vector<std::string>& names);
  Descriptors ReadDescriptors(std::uint32_t image_id);
  // Size of every feature: the area of its frame, square px.
  std::vector<float> ReadFeatureSizes(std::uint32_t image_id);
  // Adds the matches and verified pairs of another database with the same images and other pairs.
  void TakeMatches(const std::filesystem::path& other);
  // Pairs of images that passed the geometric verification, and the matches that they share.
  int CountVerifiedPairs();
  std::int64_t CountVerifiedMatches();

  // Gives the images these cameras in place of those of the extractor. `prior` says that the focal
  // length is known and not only a guess.
  struct CameraRow {
    ColmapCamera camera;
    int width = 0, height = 0;
    bool prior = false;
    std::vector<std::uint32_t> image_ids;
  };
  void ReplaceCameras(const std::vector<CameraRow>& cameras);

 private:
  std::filesystem::path file_;
  sqlite3* database_ = nullptr;
};

}  // namespace lamella
