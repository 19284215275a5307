#include "daemon/prepare/model_file.hpp"

#include <filesystem>
#include <utility>

#include "daemon/placement/plate_arrangement.hpp"
#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

const models::Facets kTwelveFacets = models::box({0, 0, 0}, {20, 20, 20});

constexpr std::uint64_t kAnyNumber = 1'000'000;

std::string refusal_of(const fs::path& path, const std::string& name = "") {
  return testing::message_of<JobRefused>([&] {
    (void)open_model_files({path, {}, Links::Refuse}, name).files.front().read(kAnyNumber);
  });
}

}  // namespace

TEST_CASE("A model is read from the file that was opened, even if another file has replaced it") {
  const testing::TemporaryFolder folder;
  const fs::path path = folder.path() / "part.stl";
  models::write_binary_stl(path, kTwelveFacets);
  ModelFile replaced = std::move(open_model_files({path, {}, Links::Refuse}, "").files.front());
  CHECK(replaced.outline().most_facets == 12);
  fs::rename(folder.write("other.stl", "no model"), path);
  CHECK(replaced.read(kAnyNumber).facets.size() == 12);
}

TEST_CASE("A model file that has grown since it was opened is read only to its former end") {
  const testing::TemporaryFolder folder;
  const fs::path path = folder.path() / "part.stl";
  models::write_binary_stl(path, kTwelveFacets);
  ModelFile grown = std::move(open_model_files({path, {}, Links::Refuse}, "").files.front());
  fs::resize_file(path, fs::file_size(path) + 50'000'000);
  const Model model = grown.read(kAnyNumber);
  CHECK(model.facets.size() == 12);
  CHECK(model.warnings.empty());
}

TEST_CASE("An error names the model if the job has several") {
  const testing::TemporaryFolder folder;
  CHECK(refusal_of(folder.write("bad.stl", "no model")).starts_with("not a usable model: "));
  CHECK(refusal_of(folder.write("bad.stl", "no model"), "bad.stl")
            .starts_with("bad.stl: not a usable model: "));
  models::write_binary_stl(folder.path() / "none.stl", {});
  CHECK(refusal_of(folder.path() / "none.stl") == "the file holds no facets");
  CHECK(refusal_of(folder.path() / "gone.stl").ends_with("gone.stl: there is no such file"));
}
