#include "daemon/camera/camera.hpp"

#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;

namespace {

namespace fs = std::filesystem;

constexpr std::int32_t kLayers = 100;

// A camera whose socket has no listener, so that every picture fails at once.
class CameraFixture {
 public:
  CameraFixture() {
    for (const char* each : {"printing", "done", "failed"})
      fs::create_directory(folder.path() / each);
    config.spool_folder = folder.path();
    config.min_free_disk_bytes = 0;
    config.camera = CameraConfig{folder.path() / "camera.socket", 5, std::chrono::seconds(1)};
  }
  Camera& camera() {
    if (!camera_) camera_.emplace(loop, log.log, config);
    return *camera_;
  }
  using Step = std::function<bool()>;
  // Runs the loop until each step has returned true, one after the other.
  bool run(const std::vector<Step>& steps) {
    auto next = steps.begin();
    return testing::run_loop_until(loop, [&] {
      if ((*next)()) ++next;
      return next == steps.end();
    });
  }
  // Lets the camera look at a layer, from 0, and waits for the picture to fail.
  Step look_at(std::int32_t layer, const std::string& job = "part") {
    return [this, layer, job, looked = false, before = std::uint64_t{0}]() mutable {
      if (std::exchange(looked, true)) return failed() > before;
      camera().look({job, layer, kLayers, Nanometers{}});
      before = failed();
      return false;
    };
  }
  std::uint64_t failed() { return camera().figures() ? camera().figures()->failed : 0; }
  std::uint64_t skipped() { return camera().figures() ? camera().figures()->skipped : 0; }

  testing::TemporaryFolder folder;
  PrinterConfig config = testing::simulated_config(folder.path());
  EventLoop loop;
  testing::LogText log{loop};

 private:
  std::optional<Camera> camera_;
};

}  // namespace

TEST_CASE_METHOD(CameraFixture, "The camera looks at every fifth layer, and logs a print's first failure") {
  for (std::int32_t layer = 0; layer < 4; ++layer)
    camera().look({"part", layer, kLayers, Nanometers{}});
  CHECK_FALSE(camera().figures());
  REQUIRE(run({look_at(4), look_at(9), look_at(14)}));
  CHECK(camera().figures()->pictures == 0);
  CHECK_FALSE(camera().figures()->trouble.empty());
  CHECK(log.count("no picture of layer 5: no service listens at") == 1);
  CHECK(log.count("no picture of layer") == 1);
}

TEST_CASE_METHOD(CameraFixture, "A picture that is due while one is being taken is skipped") {
  for (const std::int32_t layer : {4, 9, 14})
    camera().look({"part", layer, kLayers, Nanometers{}});
  CHECK(skipped() == 2);
  REQUIRE(run({[this] { return failed() == 1; }, look_at(19)}));
  CHECK(skipped() == 2);
}

TEST_CASE_METHOD(CameraFixture, "Of a print with very many layers at most a thousand pictures are taken") {
  config.camera->every_layers = 1;
  constexpr std::int32_t kMany = 2'500;
  for (std::int32_t layer = 0; layer < kMany; ++layer)
    camera().look({"part", layer, kMany, Nanometers{}});
  CHECK(1 + skipped() == 833);  // every third; the loop has not run, so that all but the first are skipped
}

TEST_CASE_METHOD(CameraFixture,
                 "The figures begin again with each print, and are summed up when it is filed") {
  REQUIRE(run({look_at(4), look_at(9),
               [this] {
                 camera().job_filed("part");
                 return true;
               },
               [this] { return log.has("part: 0 pictures, 2 failed, 0 skipped"); }, look_at(4, "next")}));
  CHECK(camera().figures()->job == "next");
  CHECK(failed() == 1);
  CHECK(log.count("no picture of layer") == 2);  // one each print
}

TEST_CASE_METHOD(CameraFixture, "Without a camera in the configuration nothing is looked at") {
  config.camera.reset();
  camera().look({"part", 4, kLayers, Nanometers{}});
  camera().job_filed("part");
  CHECK_FALSE(camera().exists());
  CHECK_FALSE(camera().figures());
  CHECK_FALSE(fs::exists(folder.path() / "pictures"));
}

TEST_CASE_METHOD(CameraFixture, "No picture is taken if the disk would not keep its room") {
  config.min_free_disk_bytes = std::numeric_limits<std::uintmax_t>::max() / 2;
  REQUIRE(run({look_at(4)}));
  CHECK(camera().figures()->trouble == "the disk has no room for pictures");
}

TEST_CASE_METHOD(CameraFixture, "A print has at most a thousand pictures") {
  const PictureFolders folders(folder.path());
  folders.make("part");
  for (std::int32_t layer = 100; layer < 1'100; ++layer)
    std::ofstream(picture_file(folders.current("part"), layer)) << "x";
  REQUIRE(run({look_at(4)}));
  CHECK(camera().figures()->pictures == 1'000);
  CHECK(camera().figures()->trouble.starts_with("it has 1000 pictures with 0 MB"));
}
