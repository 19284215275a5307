#include "daemon/formats/model_input.hpp"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/model.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/formats/packed_models.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using contourd::testing::gzipped;
using contourd::testing::message_of;
using contourd::testing::PackedFile;
using contourd::testing::same_facets;
using contourd::testing::stl_text;
using contourd::testing::threemf_files;
using contourd::testing::threemf_object;
using contourd::testing::threemf_part;
using contourd::testing::zipped;

constexpr std::uint64_t kManyFacets = 10'000'000;

using Names = std::vector<std::string>;

Model read_packed(std::string_view bytes, const Names& names = {}) {
  const testing::TemporaryFolder folder;
  const auto input = open_model(folder.write("no-name", bytes), names);
  Model model = input->read(kManyFacets);
  // An exact outline is the number of facets.
  if (input->outline().exact) CHECK(input->outline().most_facets >= model.facets.size());
  return model;
}

std::string refusal_of_packed(std::string_view bytes, const Names& names = {}) {
  return message_of<ModelError>([&] { return read_packed(bytes, names); });
}

const models::Facets& ball() {
  static const models::Facets kBall = models::sphere(4, 12);
  return kBall;
}

// Changes a field of 32 bits in every entry of the archive's directory.
std::string with_directory_field(std::string archive, std::size_t offset, std::uint32_t value) {
  for (std::size_t at = archive.find("PK\x01\x02"); at != std::string::npos;
       at = archive.find("PK\x01\x02", at + 4))
    std::memcpy(archive.data() + at + offset, &value, sizeof value);
  return archive;
}

}  // namespace

TEST_CASE(
    "A model has the same facets as STL, in a gzip archive and in a ZIP archive, whatever the file's name") {
  const std::string binary = stl_text(ball()), ascii = models::to_ascii_stl(ball());
  for (const std::string& text : {binary, ascii}) {
    CHECK(same_facets(read_packed(text).facets, ball()));
    CHECK(same_facets(read_packed(gzipped(text)).facets, ball()));
    CHECK(same_facets(read_packed(zipped({{"ball.stl", text}})).facets, ball()));
    CHECK(same_facets(read_packed(zipped({{"a/b/ball.STL", text}})).facets, ball()));
  }
}

TEST_CASE("A binary STL file is read as such even if its header is that of an archive") {
  for (const std::string_view magic : {std::string_view("\x1F\x8B\x08"), std::string_view("PK\x03\x04")}) {
    std::string text = stl_text(ball());
    text.replace(0, magic.size(), magic);
    CHECK(same_facets(read_packed(text).facets, ball()));
  }
}

TEST_CASE("A gzip archive that is cut short or damaged anywhere is refused") {
  const std::string whole = gzipped(stl_text(ball()));
  for (const std::size_t bytes : {std::size_t{2}, std::size_t{17}, whole.size() / 2, whole.size() - 1})
    CHECK(lacking(refusal_of_packed(std::string_view(whole).substr(0, bytes)), {"gzip archive"}).empty());
  for (const std::size_t at : {whole.size() / 2, whole.size() - 6, whole.size() - 2}) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    CHECK_FALSE(refusal_of_packed(damaged).empty());
  }
  CHECK_FALSE(refusal_of_packed(whole + whole).empty());
  CHECK(
      lacking(refusal_of_packed(whole + "junk"), {"cut short or damaged, or other data follows it"}).empty());
}

TEST_CASE("Zeros after a gzip archive are ignored, as gzip ignores them") {
  for (const std::size_t zeros : {1U, 3U, 4U, 512U, 100'000U}) {
    CAPTURE(zeros);
    const std::string padding(zeros, '\0');
    CHECK(same_facets(read_packed(gzipped(stl_text(ball())) + padding).facets, ball()));
    CHECK(lacking(refusal_of_packed(gzipped(stl_text(ball())) + padding + "junk"), {"other data"}).empty());
  }
  const std::string bomb(64'000'000, '\0');
  CHECK(lacking(refusal_of_packed(gzipped(bomb) + std::string(512, '\0')), {"more than 200 times as much"})
            .empty());
}

TEST_CASE("A 3MF file in a gzip archive is read") {
  CHECK(same_facets(read_packed(gzipped(testing::threemf_of(ball()))).facets, ball()));
  CHECK(lacking(refusal_of_packed(gzipped(zipped({{"ball.stl", stl_text(ball())}}))),
                {"gzip archive: it is an archive in an archive: unpack it"})
            .empty());
}

TEST_CASE("Every refusal of a model in a ZIP archive names the model once") {
  const std::string bad_3mf = zipped(threemf_files(threemf_part(threemf_object(1, ball()), "")));
  for (const auto& [name, text] :
       {std::pair<std::string, std::string>("a/bad.stl", "solid a\nfacet x\nendsolid\n"),
        {"a/bad.obj", "v 0 0 0\nf 1 2 3\n"},
        {"a/bad.amf", "<amf><constellation id=\"1\"><instance objectid=\"7\"/></constellation></amf>"},
        {"a/broken.amf", "<amf><object>"},
        {"a/bad.3mf", bad_3mf}}) {
    CAPTURE(name);
    const std::string refusal = refusal_of_packed(zipped({{name, text}}));
    CHECK(refusal.starts_with("\"" + name + "\" in the archive: "));
    CHECK(refusal.find(name) == refusal.rfind(name));
  }
}

TEST_CASE("The chosen version of a model in an archive is a warning of the model") {
  const models::Facets box = models::box({0, 0, 0}, {1, 2, 3});
  const Model model = read_packed(
      zipped({{"Supported/part.stl", stl_text(box)}, {"Unsupported/part.stl", stl_text(ball())}}));
  CHECK(same_facets(model.facets, box));
  REQUIRE(model.warnings.size() == 1);
  CHECK(
      lacking(model.warnings[0], {"with supports and without", "\"Supported/part.stl\" is printed"}).empty());
}

TEST_CASE("A gzip archive of something that is no model is refused by what it holds") {
  CHECK(lacking(refusal_of_packed(gzipped("%PDF-1.4 and so on, with some more text to be long enough")),
                {"the model in the gzip archive: ", "a PDF document"})
            .empty());
  CHECK(lacking(refusal_of_packed(gzipped("")), {"the file is empty"}).empty());
}

TEST_CASE("Files that macOS adds, hidden files and folders are no models of an archive") {
  const std::string text = stl_text(ball());
  CHECK(same_facets(read_packed(zipped({{"__MACOSX/._ball.stl", "x"},
                                        {"pack/", ""},
                                        {"pack/.hidden/other.stl", "x"},
                                        {"pack/._ball.stl", "x"},
                                        {"pack/readme.txt", "x"},
                                        {"pack/ball.stl", text}}))
                        .facets,
                    ball()));
}

TEST_CASE("Of an archive with several models, the one that the ticket names is read") {
  const models::Facets box = models::box({0, 0, 0}, {1, 2, 3});
  const std::string archive = zipped({{"Supported/part.stl", stl_text(box)},
                                      {"Unsupported/part.stl", stl_text(ball())},
                                      {"base.stl", stl_text(box)}});
  CHECK(lacking(refusal_of_packed(archive),
                {"holds 2 models: name one of them as \"model\" in the ticket", "\"Supported/part.stl\""})
            .empty());
  CHECK(same_facets(read_packed(archive, {"Unsupported/part.stl"}).facets, ball()));
  CHECK(same_facets(read_packed(archive, {"base.stl"}).facets, box));
  CHECK(lacking(refusal_of_packed(archive, {"part.stl"}), {"2 models \"part.stl\"", "with its folder"})
            .empty());
  CHECK(lacking(refusal_of_packed(archive, {"none.stl"}), {"no model and no folder \"none.stl\""}).empty());
  CHECK(lacking(refusal_of_packed(stl_text(box), {"part.stl"}), {"is no ZIP archive"}).empty());
}

TEST_CASE("An archive without a model is refused by what it holds") {
  CHECK(refusal_of_packed(zipped({{"readme.txt", "x"}})) ==
        "the archive holds no model: a model's name in an archive ends in .stl, .3mf, .obj or .amf");
  CHECK(lacking(refusal_of_packed(zipped({{"more.zip", "x"}})), {"another archive, \"more.zip\""}).empty());
  CHECK(lacking(refusal_of_packed(zipped({{"config.ini", "x"}, {"part.svg", "x"}})), {"sliced"}).empty());
  CHECK_FALSE(
      refusal_of_packed(std::string_view("PK\x05\x06\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0", 22)).empty());
}

TEST_CASE("A model in an archive that is encrypted, a link or damaged is refused with its name") {
  const std::string text = stl_text(ball());
  CHECK(lacking(refusal_of_packed(zipped({PackedFile{"a.stl", text, false, "secret"}})),
                {"\"a.stl\" is encrypted"})
            .empty());
  CHECK(
      lacking(refusal_of_packed(zipped({PackedFile{"a.stl", "/etc/passwd", true}})), {"\"a.stl\" is a link"})
          .empty());
  std::string damaged = zipped({{"a.stl", text}});
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x55);
  CHECK(lacking(refusal_of_packed(damaged), {"\"a.stl\" in the archive"}).empty());
  const std::string whole = zipped({{"a.stl", text}});
  CHECK(
      lacking(refusal_of_packed(std::string_view(whole).substr(0, whole.size() - 30)), {"damaged"}).empty());
}

TEST_CASE("An archive that lies about the size of a model is refused before memory is taken for it") {
  constexpr std::size_t kInflatedSize = 24;  // offset in an entry of the directory
  const std::string archive = zipped({{"a.stl", stl_text(ball())}});
  CHECK_FALSE(refusal_of_packed(with_directory_field(archive, kInflatedSize, 84)).empty());
  CHECK_FALSE(refusal_of_packed(with_directory_field(archive, kInflatedSize, 100'000'000)).empty());
  CHECK(
      lacking(refusal_of_packed(with_directory_field(archive, kInflatedSize, 0xF000'0000)), {"the limit is"})
          .empty());
}

TEST_CASE("A package that lies about the size of its model is read no further than it claims") {
  constexpr std::size_t kInflatedSize = 24, kName = 46;  // offsets in an entry of the directory
  const std::string part = threemf_part(threemf_object(1, ball()), "<item objectid=\"1\"/>");
  std::string archive = zipped(threemf_files(part + std::string(1'000'000, ' ')));
  const std::uint32_t claimed = 5'000;
  std::memcpy(archive.data() + archive.rfind("3D/3dmodel.model") - kName + kInflatedSize, &claimed,
              sizeof claimed);
  CHECK(lacking(refusal_of_packed(archive), {"3dmodel.model", "more bytes than it claims"}).empty());
}

TEST_CASE("A bomb, which becomes far larger when it is unpacked, is refused by its ratio") {
  const std::string zeros(64'000'000, '\0');
  CHECK(lacking(refusal_of_packed(zipped({{"a.stl", zeros}})),
                {"\"a.stl\" in the archive has", "more than 200 times as much"})
            .empty());
  CHECK(lacking(refusal_of_packed(gzipped(zeros)), {"more than 200 times as much"}).empty());
}

TEST_CASE("An archive with too many entries is refused before they are listed") {
  std::vector<PackedFile> files;
  for (int i = 0; i < 10'001; ++i)
    files.push_back({std::to_string(i), ""});
  CHECK(lacking(refusal_of_packed(zipped(files)), {"10001 entries"}).empty());
}
