// The values that were asked for most recently, by index; made when they are missing.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <utility>

namespace lamella {

// Not for use from many threads. A value lives on while someone holds its pointer.
template <class T>
class Recent {
 public:
  Recent(std::size_t capacity, std::function<T(int index)> make)
      : capacity_(std::max<std::size_t>(capacity, 1)), make_(std::move(make)) {}

  void Clear() { entries_.clear(); }

  std::shared_ptr<const T> Get(int index) {
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& entry) { return entry.first == index; });
    if (found != entries_.end()) {
      entries_.splice(entries_.begin(), entries_, found);
    } else {
      if (entries_.size() >= capacity_) entries_.pop_back();
      entries_.emplace_front(index, std::make_shared<const T>(make_(index)));
    }
    return entries_.front().second;
  }

 private:
  using Entry = std::pair<int, std::shared_ptr<const T>>;
  std::size_t capacity_;
  std::function<T(int)> make_;
  std::list<Entry> entries_;  // newest first
};

}  // namespace lamella
