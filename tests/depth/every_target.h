// Runs a check once per instruction set that this processor has.
#pragma once

#include <functional>

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace lamella {

inline void ForEveryTarget(const std::function<void()>& check) {
  const auto choose = [](std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  };
  hwy::SetSupportedTargetsForTest(0);
  const std::int64_t all = hwy::SupportedTargets();
  for (std::int64_t rest = all; rest != 0; rest &= rest - 1) {
    const std::int64_t target = rest & -rest;
    choose(target);
    SCOPED_TRACE(hwy::TargetName(target));
    check();
  }
  choose(0);
}

}  // namespace lamella
