// Pictures and maps in memory, in place of the stage's files.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "depth/estimate.h"

namespace lamella {

class MemoryStore final : public DepthStore {
 public:
  explicit MemoryStore(std::vector<Image<Rgb8>> photographs)
      : photographs_(std::move(photographs)) {}
  Image<Rgb8> Photograph(int view) override {
    return photographs_.at(static_cast<std::size_t>(view)).Clone();
  }
  bool Has(int pass, int view) const override {
    const std::lock_guard lock(*mutex_);
    return maps.count({pass, view}) > 0;
  }
  DepthMap Load(int pass, int view) override {
    const std::lock_guard lock(*mutex_);
    return Copy(maps.at({pass, view}));
  }
  void Save(int pass, int view, const DepthMap& map) override {
    const std::lock_guard lock(*mutex_);
    ++saved;
    maps[{pass, view}] = Copy(map);
  }
  std::map<std::pair<int, int>, DepthMap> maps;
  int saved = 0;

 private:
  static DepthMap Copy(const DepthMap& map) { return {map.depth.Clone(), map.confidence.Clone()}; }
  std::vector<Image<Rgb8>> photographs_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();  // so that stores move
};

}  // namespace lamella
