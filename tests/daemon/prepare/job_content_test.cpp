#include "daemon/prepare/job_content.hpp"

#include <map>
#include <string>
#include <vector>

#include "daemon/prepare/preprint_analysis.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/formats/packed_models.hpp"
#include "tests/daemon/prepare/print_job_fixture.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using contourd::testing::lacking;
using contourd::testing::stl_text;

// Jobs of an archive, and of the same models as a plate.
class ArchiveFixture : public testing::PlateFixture {
 public:
  void pack(const std::string& path, const models::Facets& facets) {
    files_.push_back({path, stl_text(facets)});
  }

  PreparedJob prepare_archive(const std::string& ticket = "") {
    JobFiles files{"pack", folder_.write("pack.zip", testing::zipped(files_)), std::nullopt};
    if (!ticket.empty()) files.ticket = folder_.write("pack.json", ticket);
    return prepare_job(files, read_settings(files, printer), printer);
  }
  std::string refusal_of_archive(const std::string& ticket = "") {
    return testing::refusal_by([&] { (void)prepare_archive(ticket); });
  }

 private:
  testing::TemporaryFolder folder_;
  std::vector<testing::PackedFile> files_;
};

const models::Facets kBar = models::box({0, 0, 0}, {8, 3, 5});

std::string text_of_warnings(const PreparedJob& job) {
  std::string text;
  for (const std::string& warning : job.summary.warnings)
    text += warning + "\n";
  return text;
}

}  // namespace

TEST_CASE_METHOD(ArchiveFixture, "An archive of several models has the masks of the same models as a plate") {
  const std::map<std::string, models::Facets> models{
      {"ball.stl", models::sphere(6, 24)}, {"bar.stl", kBar}, {"cube.stl", testing::kCube}};
  for (const auto& [name, facets] : models) {
    add(name, facets);
    pack("folder/" + name, facets);
  }
  for (const char* const supports : {"off", "auto"}) {
    const std::string policy = std::string("\"supports\": \"") + supports + "\"";
    PreparedJob archive = prepare_archive("{" + policy + "}");
    PreparedJob plate = prepare(
        "{" + policy + R"(, "models": [{"file": "ball.stl"}, {"file": "bar.stl"}, {"file": "cube.stl"}]})");
    REQUIRE(archive.plan.expected_layers == plate.plan.expected_layers);
    for (const Nanometers height : middles_of(plate.plan.expected_layers)) {
      const Mask& mask = archive.plan.engine->mask_at(height);
      const Mask& other = plate.plan.engine->mask_at(height);
      REQUIRE(mask == other);
    }
  }
}

TEST_CASE_METHOD(ArchiveFixture, "Models of an archive are named by their paths, in reports and refusals") {
  pack("a/cube.stl", testing::kCube);
  pack("b/bar.stl", kBar);
  const PreparedJob job = prepare_archive();
  CHECK(job.summary.plate);
  CHECK(job.summary.models[0].file == "a/cube.stl");
  CHECK(job.summary.models[1].file == "b/bar.stl");
  CHECK(lacking(text_of_warnings(job), {"2 models of the archive are printed together", "\"b/bar.stl\""})
            .empty());
  CHECK_FALSE(analysis_of_preparation(job.summary));
  // One model of an archive is no plate, but its path is known.
  const PreparedJob one = prepare_archive(R"({"model": "bar.stl"})");
  CHECK_FALSE(one.summary.plate);
  CHECK(one.summary.models.front().file == "b/bar.stl");
  CHECK(prepare_archive(R"({"model": ["a", "b/bar.stl"], "copies": 2})").summary.models[1].centers.size() ==
        2);
  CHECK(lacking(refusal_of_archive(R"({"position_mm": {"x": 1}})"),
                {"2 models", "position_mm in the ticket is for one"})
            .empty());
  pack("c/flat.stl", models::box({0, 0, 3}, {10, 10, 3}));
  CHECK(lacking(refusal_of_archive(), {"c/flat.stl is flat", "\"model\" in the ticket chooses"}).empty());
}

TEST_CASE_METHOD(ArchiveFixture, "Models of an archive without room on the plate wait for confirmation") {
  pack("wide.stl", models::box({0, 0, 0}, {90, 30, 2}));
  pack("huge.stl", models::box({0, 0, 0}, {200, 200, 60}));
  pack("long.stl", models::box({0, 0, 0}, {80, 25, 3}));
  pack("small.stl", models::box({0, 0, 0}, {10, 10, 1}));
  const PreparedJob job = prepare_archive();
  REQUIRE(job.summary.models.size() == 2);
  CHECK(job.summary.models[0].file == "wide.stl");
  CHECK(job.summary.models[1].file == "small.stl");
  CHECK(job.summary.height_mm == 2);  // not that of a model that is left out
  const auto analysis = analysis_of_preparation(job.summary);
  REQUIRE(analysis);
  CHECK(analysis->findings == std::vector<std::string>{"left_out_models"});
  CHECK(asked_findings(*analysis, printer) == analysis->findings);
  CHECK(lacking(job.summary.left_out, {"2 of the 4 models", "96.00 x 54.00 mm", "\"huge.stl\", \"long.stl\"",
                                       "\"model\" in a ticket chooses"})
            .empty());
  CHECK(prepare_archive(R"({"model": "long.stl"})").summary.left_out.empty());
  CHECK(lacking(refusal_of_archive(R"({"model": "huge.stl"})"), {"200.00"}).empty());
}

TEST_CASE_METHOD(ArchiveFixture, "A model that only its name calls supported waits until the ticket answers",
                 "[long]") {
  pack("Supported/ball.stl", models::sphere(2, 12));
  const JobSummary in_doubt = prepare_archive(R"({"supports": "auto"})").summary;
  const auto analysis = analysis_of_preparation(in_doubt);
  REQUIRE(analysis);
  CHECK(asked_findings(*analysis, printer) == std::vector<std::string>{"supports_in_doubt"});
  CHECK(lacking(in_doubt.supports_question,
                {"the name of the model says that it carries supports", "\"supports\": \"in the file\""})
            .empty());
  for (const char* const answer : {"in the file", "on", "off"})
    CHECK_FALSE(
        analysis_of_preparation(prepare_archive(R"({"supports": ")" + std::string(answer) + "\"}").summary));
}

TEST_CASE_METHOD(ArchiveFixture, "The name of a model that needs no supports does not make it wait") {
  pack("cube_supported.stl", testing::kCube);
  CHECK_FALSE(analysis_of_preparation(prepare_archive(R"({"supports": "auto"})").summary));
  // Nor do the supports of another model of its plate.
  pack("ball.stl", models::sphere(2, 12));
  const JobSummary plate = prepare_archive(R"({"supports": "auto"})").summary;
  CHECK_FALSE(plate.supports->contacts.empty());
  CHECK(plate.supports_question.empty());
}

TEST_CASE_METHOD(ArchiveFixture, "A model that its archive calls supported is printed as it is") {
  // A ball on a few pins would get supports.
  const models::Facets ball = models::sphere(6, 24);
  pack("Supported/ball.stl", ball);
  pack("Unsupported/ball.stl", ball);
  PreparedJob job = prepare_archive(R"({"supports": "auto", "up": "auto"})");
  REQUIRE(job.summary.models.size() == 1);
  CHECK(job.summary.models.front().file == "Supported/ball.stl");
  CHECK(job.summary.height_mm == testing::Approx(12).margin(0.01));
  CHECK(job.summary.supports->contacts.empty());
  CHECK(lacking(text_of_warnings(job),
                {"versions with supports and without", "carries supports in its file", "is not turned"})
            .empty());
  job = prepare_archive(R"({"supports": "on"})");
  CHECK(job.summary.models.front().file == "Unsupported/ball.stl");
  CHECK_FALSE(job.summary.supports->contacts.empty());
}
