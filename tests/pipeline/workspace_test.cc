#include "pipeline/workspace.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

Workspace Fresh() { return Workspace(ScratchFolder()); }

TEST(StageRun, IsDoneOnlyWhenCommittedWithTheSameHashes) {
  const Workspace workspace = Fresh();
  EXPECT_FALSE(IsDone(workspace, "depth", "in", "opt"));
  {
    StageRun run(workspace, "depth", "in", "opt");
    WriteTextAtomically(run.folder() / "a.txt", "a");
    EXPECT_FALSE(IsDone(workspace, "depth", "in", "opt"));
    run.Commit({{{"views", "3"}}, {"careful"}, ""}, 1.5, 20);
  }
  EXPECT_TRUE(IsDone(workspace, "depth", "in", "opt"));
  EXPECT_FALSE(IsDone(workspace, "depth", "other", "opt"));
  EXPECT_FALSE(IsDone(workspace, "depth", "in", "other"));
  const StageRecord record = *LoadStageRecord(workspace, "depth");
  EXPECT_EQ(record.report.summary.at(0).second, "3");
  EXPECT_EQ(record.report.warnings.at(0), "careful");
}

TEST(StageRun, IsNotDoneWhereAnOutputIsMissingOrCut) {
  const Workspace workspace = Fresh();
  {
    StageRun run(workspace, "depth", "in", "opt");
    WriteTextAtomically(run.folder() / "a.txt", "abc");
    run.Commit({}, 0, 0);
  }
  WriteTextAtomically(workspace.Stage("depth") / "a.txt", "ab");
  EXPECT_FALSE(IsDone(workspace, "depth", "in", "opt"));
  fs::remove(workspace.Stage("depth") / "a.txt");
  EXPECT_FALSE(IsDone(workspace, "depth", "in", "opt"));
}

TEST(StageRun, KeepsFinishedFilesOfAKilledRunOfTheSameKeyOnly) {
  const Workspace workspace = Fresh();
  {
    StageRun run(workspace, "depth", "in", "opt");
    WriteTextAtomically(run.folder() / "a.txt", "a");
    WriteTextAtomically(run.folder() / "b.partial.txt", "half");
  }
  {
    StageRun again(workspace, "depth", "in", "opt");
    EXPECT_TRUE(again.Finished("a.txt"));
    EXPECT_FALSE(fs::exists(again.folder() / "b.partial.txt"));
  }
  StageRun other(workspace, "depth", "in", "other");
  EXPECT_FALSE(other.Finished("a.txt"));
  EXPECT_FALSE(fs::exists(other.folder() / "a.txt"));
}

TEST(StageRun, BeginsWhereOneWasKilledBeforeItsRecordWasWhole) {
  const Workspace workspace(ScratchFolder());
  fs::create_directories(workspace.Stage("depth"));
  WriteTextAtomically(workspace.Stage("depth") / "stage.partial.json", "{");
  EXPECT_NO_THROW(StageRun(workspace, "depth", "i", "o"));
  EXPECT_FALSE(fs::exists(workspace.Stage("depth") / "stage.partial.json"));
}

TEST(StageRun, DoesNotTouchAFolderThatIsNotItsOwn) {
  const Workspace workspace = Fresh();
  CreateFolder(workspace.Stage("depth"));
  WriteTextAtomically(workspace.Stage("depth") / "mine.txt", "mine");
  EXPECT_THROW(StageRun(workspace, "depth", "in", "opt"), Error);
  EXPECT_TRUE(fs::exists(workspace.Stage("depth") / "mine.txt"));
}

TEST(StageRecord, RefusesANewerFormat) {
  const Workspace workspace = Fresh();
  CreateFolder(workspace.Stage("depth"));
  WriteTextAtomically(workspace.Stage("depth") / "stage.json", "{\"format_version\": 2}");
  EXPECT_THROW(LoadStageRecord(workspace, "depth"), Error);
  WriteTextAtomically(workspace.Stage("depth") / "stage.json", "{\"format_ver");
  EXPECT_THROW(LoadStageRecord(workspace, "depth"), Error);
}

}  // namespace
}  // namespace lamella
