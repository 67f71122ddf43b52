// The values that were asked for most recently, by index; made when they are missing.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <utility>
#include <vector>

#include "lightfield/parallel.h"

namespace lamella {

// Not for use from many threads, though `make` may be called from many. A value lives on while
// someone holds its pointer.
template <class T>
class Recent {
 public:
  Recent(std::size_t capacity, std::function<T(int index)> make)
      : capacity_(std::max<std::size_t>(capacity, 1)), make_(std::move(make)) {}

  void Clear() { entries_.clear(); }

  // Those of the indices; missing ones are made side by side.
  std::vector<std::shared_ptr<const T>> Get(const std::vector<int>& indices) {
    std::vector<std::shared_ptr<const T>> values(indices.size());
    ParallelForEach(0, static_cast<std::int64_t>(indices.size()), [&](std::int64_t i) {
      const auto at = static_cast<std::size_t>(i);
      const bool repeated =
          std::find(indices.begin(), indices.begin() + i, indices[at]) != indices.begin() + i;
      if (!repeated && Find(indices[at]) == entries_.end()) {
        values[at] = std::make_shared<const T>(make_(indices[at]));
      }
    });
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (values[i]) {
        Enter(indices[i], values[i]);
      } else {
        values[i] = Get(indices[i]);
      }
    }
    return values;
  }

  std::shared_ptr<const T> Get(int index) {
    const auto found = Find(index);
    if (found != entries_.end()) {
      entries_.splice(entries_.begin(), entries_, found);
    } else {
      Enter(index, std::make_shared<const T>(make_(index)));
    }
    return entries_.front().second;
  }

 private:
  using Entry = std::pair<int, std::shared_ptr<const T>>;

  auto Find(int index) {
    return std::find_if(entries_.begin(), entries_.end(),
                        [&](const Entry& entry) { return entry.first == index; });
  }
  void Enter(int index, std::shared_ptr<const T> value) {
    if (entries_.size() >= capacity_) entries_.pop_back();
    entries_.emplace_front(index, std::move(value));
  }

  std::size_t capacity_;
  std::function<T(int)> make_;
  std::list<Entry> entries_;  // newest first
};

}  // namespace lamella
