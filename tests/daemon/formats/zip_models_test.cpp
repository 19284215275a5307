#include "daemon/formats/zip_models.hpp"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "core/formats/file_bytes.hpp"
#include "core/model/model.hpp"
#include "daemon/formats/model_input.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/formats/packed_models.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using contourd::testing::PackedFile;
using contourd::testing::stl_text;
using contourd::testing::TemporaryFolder;
using contourd::testing::threemf_of;
using contourd::testing::zipped;
using Paths = std::vector<std::string>;

constexpr std::uint64_t kEnoughFacets = 1'000'000;

const std::string& box_text() {
  static const std::string kText = stl_text(models::box({0, 0, 0}, {1, 2, 3}));
  return kText;
}

std::vector<PackedFile> boxes(const Paths& paths) {
  std::vector<PackedFile> files;
  for (const std::string& path : paths)
    files.push_back({path, box_text()});
  return files;
}

OpenedModels opened(const std::string& archive, const ArchiveChoice& choice = {}) {
  const TemporaryFolder folder;
  return open_models(folder.write("a.zip", archive), choice);
}

Paths chosen_of(const std::string& archive, const ArchiveChoice& choice = {}) {
  Paths paths;
  for (const OpenedModel& model : opened(archive, choice).models)
    paths.push_back(model.entry);
  return paths;
}

std::string notes_of(const std::string& archive, const ArchiveChoice& choice = {}) {
  std::string text;
  for (const std::string& note : opened(archive, choice).notes)
    text += note + "\n";
  return text;
}

std::string refusal_of_archive(const std::string& archive, const ArchiveChoice& choice = {}) {
  return testing::message_of<ModelError>([&] {
    for (OpenedModel& model : opened(archive, choice).models)
      (void)model.input->read(kEnoughFacets);
  });
}

// Sets the size that the archive's directory claims for each entry.
std::string with_claimed_size(std::string archive, std::uint32_t bytes) {
  constexpr std::size_t kInflatedSize = 24;
  for (std::size_t at = archive.find("PK\x01\x02"); at != std::string::npos;
       at = archive.find("PK\x01\x02", at + 4))
    std::memcpy(archive.data() + at + kInflatedSize, &bytes, sizeof bytes);
  return archive;
}

}  // namespace

TEST_CASE("All models of an archive are opened, whatever their folders and formats") {
  const models::Facets ball = models::sphere(4, 12);
  std::vector<PackedFile> files = boxes({"a/one.stl", "b\\two.STL"});
  files.push_back({"c/three.3mf", threemf_of(ball)});
  files.push_back({"four.obj", "v 0 0 0\nv 0 0 1\nv 0 1 0\nv 1 0 0\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n"});
  OpenedModels models = opened(zipped(files));
  REQUIRE(models.models.size() == 4);
  const Paths paths{"a/one.stl", "b\\two.STL", "c/three.3mf", "four.obj"};
  const std::vector<std::size_t> facets{12, 12, ball.size(), 4};
  // The last one first: each has a stream of its own.
  for (std::size_t i = 4; i-- > 0;) {
    CHECK(models.models[i].entry == paths[i]);
    CHECK(models.models[i].input->read(kEnoughFacets).facets.size() == facets[i]);
  }
}

TEST_CASE("A 3MF file in an archive has the same facets as by itself") {
  const models::Facets ball = models::sphere(4, 12);
  OpenedModels models = opened(zipped({{"Part.3MF", threemf_of(ball)}}));
  REQUIRE(models.models.size() == 1);
  CHECK(models.models[0].input->outline().format == "3mf");
  CHECK(testing::same_facets(models.models[0].input->read(kEnoughFacets).facets, ball));
  CHECK(lacking(refusal_of_archive(zipped({{"a.3mf", zipped(boxes({"b.stl"}))}})),
                {"\"a.3mf\" in the archive", "an archive in an archive"})
            .empty());
  const std::string whole = threemf_of(ball);
  CHECK(lacking(refusal_of_archive(zipped({{"a.3mf", whole.substr(0, whole.size() - 9)}})),
                {"\"a.3mf\"", "damaged"})
            .empty());
}

TEST_CASE("A ticket chooses models by their paths, their names or their folders") {
  const std::string archive = zipped(boxes({"x/a.stl", "x/y/b.stl", "z/a.stl", "c.stl"}));
  CHECK(chosen_of(archive, {{"c.stl", "x/a.stl"}}) == Paths{"x/a.stl", "c.stl"});
  CHECK(chosen_of(archive, {{"b.stl"}}) == Paths{"x/y/b.stl"});
  CHECK(chosen_of(archive, {{"x"}}) == Paths{"x/a.stl", "x/y/b.stl"});
  CHECK(chosen_of(archive, {{"x/y/", "z"}}) == Paths{"x/y/b.stl", "z/a.stl"});
  CHECK(chosen_of(archive, {{"y"}}) == Paths{"x/y/b.stl"});
  CHECK(lacking(refusal_of_archive(archive, {{"a.stl"}}), {"2 models \"a.stl\"", "with its folder"}).empty());
  CHECK(lacking(refusal_of_archive(archive, {{"w"}}), {"no model and no folder \"w\"", "\"c.stl\""}).empty());
  CHECK(lacking(refusal_of_archive(archive, {{"/"}}), {"no model and no folder"}).empty());
}

TEST_CASE("Of versions with supports and without, the supported one is chosen unless others are asked for") {
  const std::string archive =
      zipped(boxes({"Unsupported/dragon.stl", "Supported/STL/dragon_sup.stl", "base.stl"}));
  CHECK(chosen_of(archive) == Paths{"Supported/STL/dragon_sup.stl", "base.stl"});
  CHECK(
      lacking(notes_of(archive),
              {"\"Supported/STL/dragon_sup.stl\" is printed, as it is, instead of \"Unsupported/dragon.stl\"",
               "\"model\": \"Unsupported/dragon.stl\""})
          .empty());
  CHECK(chosen_of(archive, {{}, true}) == Paths{"Unsupported/dragon.stl", "base.stl"});
  CHECK(lacking(notes_of(archive, {{}, true}), {"contourd's own supports"}).empty());
  CHECK(chosen_of(archive, {{"dragon.stl"}}) == Paths{"Unsupported/dragon.stl"});
  CHECK(chosen_of(archive, {{"Unsupported"}}) == Paths{"Unsupported/dragon.stl"});
  // Both, if both are asked for.
  CHECK(chosen_of(archive, {{"dragon.stl", "dragon_sup.stl"}}).size() == 2);
  const OpenedModels models = opened(archive);
  CHECK(models.models[0].is_supported);
  CHECK_FALSE(models.models[1].is_supported);
  CHECK(opened(archive, {{"Supported"}}).models[0].is_supported);
  CHECK_FALSE(opened(zipped(boxes({"a_sup.stl"}))).models[0].is_supported);
}

TEST_CASE("Of a model in several formats one is chosen, and models that only resemble each other stay") {
  const std::string archive = zipped(boxes({"OBJ/a.obj", "STL/a.stl", "b.stl", "B.stl", "b-.stl"}));
  CHECK(chosen_of(archive) == Paths{"STL/a.stl", "b.stl", "B.stl", "b-.stl"});
  CHECK(lacking(notes_of(archive), {"\"OBJ/a.obj\": left out, because \"STL/a.stl\""}).empty());
}

TEST_CASE("Projects of other slicers and archives in an archive are left out and named") {
  std::vector<PackedFile> files = boxes({"a.stl"});
  files.push_back({"Supported/a.lys", "x"});
  files.push_back({"more.zip", "x"});
  CHECK(
      lacking(notes_of(zipped(files)), {"\"Supported/a.lys\": left out", "Lychee", "\"more.zip\": left out"})
          .empty());
  CHECK(lacking(refusal_of_archive(zipped({{"Supported/a.lys", "x"}})), {"no model, but \"Supported/a.lys\""})
            .empty());
}

TEST_CASE("Names that lead out of the archive's folder are only names") {
  for (const char* const path : {"../../a.stl", "/etc/a.stl", "..\\a.stl", "C:\\a.stl", "./a.stl"})
    CHECK(chosen_of(zipped(boxes({path}))) == Paths{path});
  const std::string deep = [] {
    std::string path;
    for (int i = 0; i < 17; ++i)
      path += "d/";
    return path + "a.stl";
  }();
  CHECK(lacking(refusal_of_archive(zipped(boxes({deep}))), {"more than 16 folders"}).empty());
}

TEST_CASE("Of many models, no more are opened than a plate may have") {
  Paths paths;
  for (std::size_t i = 0; i <= kMostArchiveModels; ++i)
    paths.push_back("many/" + std::to_string(i) + ".stl");
  const std::string archive = zipped(boxes(paths));
  CHECK(lacking(refusal_of_archive(archive), {"101 models", "at most 100", "and 95 more"}).empty());
  CHECK(chosen_of(archive, {{"7.stl", "9.stl"}}) == Paths{"many/7.stl", "many/9.stl"});
}

TEST_CASE("Several models may together not become larger than one") {
  const std::string claims = with_claimed_size(zipped(boxes({"a.stl", "b.stl", "c.stl"})), 800'000'000);
  CHECK(lacking(refusal_of_archive(claims), {"times"}).empty());
  // Each of these has a plausible ratio, but all of them share a few bytes.
  std::vector<PackedFile> files;
  const std::string zeros(8'000'000, '\0');
  for (int i = 0; i < 40; ++i)
    files.push_back({std::to_string(i) + ".stl", zeros});
  CHECK(
      lacking(refusal_of_archive(zipped(files)), {"the archive, with 40 models, has", "more than 200 times"})
          .empty());
}

TEST_CASE("A broken model among good ones is refused with its path") {
  std::vector<PackedFile> files = boxes({"good/a.stl", "good/b.stl"});
  files.push_back({"bad/c.stl", "%PDF-1.4 no model"});
  CHECK(lacking(refusal_of_archive(zipped(files)), {"\"bad/c.stl\" in the archive: ", "a PDF document"})
            .empty());
  files.back() = {"bad/c.stl", box_text(), false, "secret"};
  CHECK(lacking(refusal_of_archive(zipped(files)), {"\"bad/c.stl\" is encrypted"}).empty());
  CHECK(chosen_of(zipped(files), {{"good"}}).size() == 2);
}
