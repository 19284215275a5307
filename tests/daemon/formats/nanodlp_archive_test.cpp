#include "daemon/formats/nanodlp_archive.hpp"

#include <fmt/format.h>

#include "daemon/formats/model_input.hpp"
#include "hw/png_file.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/formats/packed_models.hpp"
#include "tests/message_of.hpp"

namespace {

const DisplayGeometry kPlatePanel{Pixels{12}, Pixels{8}, Micrometers{50}};
const NanodlpTexts kPlateTexts{
    .plate = R"({"LayersCount": 3, "LayerThickness": 0})",
    .profile = R"({"Depth": 50.0, "CureTime": 2.5, "SupportCureTime": 20, "SupportLayerNumber": 4})",
    .options =
        R"({"PWidth": 12, "PHeight": 8, "XPixelSize": 0.05, "YPixelSize": 0.05, "Thickness": 50.0, "SupportDepth": 60})"};

std::string plate_picture(int layer, std::int32_t width = 12) {
  Mask mask(Pixels{width}, Pixels{8});
  mask.row(0)[0] = static_cast<std::uint8_t>(layer);
  mask.row(5)[3] = 255;
  const std::vector<std::uint8_t> bytes = encode_png(mask);
  return {bytes.begin(), bytes.end()};
}

std::vector<testing::PackedFile> plate(const NanodlpTexts& texts = kPlateTexts) {
  return {{"meta.json", "{}"},
          {"plate.json", texts.plate},
          {"profile.json", texts.profile},
          {"options.json", texts.options},
          {"2.png", plate_picture(2)},
          {"1.png", plate_picture(1)},
          {"3d.png", "x"},
          {"3.png", plate_picture(3)}};
}

class OpenedPlate {
 public:
  explicit OpenedPlate(const std::vector<testing::PackedFile>& files)
      : opened_(open_models(folder_.write("any-name", testing::zipped(files)))) {}

  const SlicedArchive& archive() { return *opened_.models.front().input->sliced(); }
  std::shared_ptr<const PictureStack> read(const DisplayGeometry& display) {
    return archive().read(display, std::uint64_t{1} << 30U, {});
  }

 private:
  testing::TemporaryFolder folder_;
  OpenedModels opened_;
};

std::string plate_refusal(const std::vector<testing::PackedFile>& files,
                          const DisplayGeometry& display = kPlatePanel) {
  return testing::message_of<ModelError>([&] { (void)OpenedPlate(files).read(display); });
}

}  // namespace

TEST_CASE("A plate of NanoDLP is recognised by its content, and its pictures are shown as they are") {
  OpenedPlate opened(plate());
  const SlicedArchive& archive = opened.archive();
  CHECK(archive.format() == std::string_view("nanodlp"));
  CHECK(archive.layers() == 3);
  const SlicedSettings& settings = archive.settings();
  CHECK(settings.layer_height == Nanometers{50'000});
  CHECK(settings.first_layer == Nanometers{60'000});
  REQUIRE(settings.exposures);
  CHECK(settings.exposures->normal == std::chrono::milliseconds(2500));
  CHECK(settings.exposures->first == std::chrono::seconds(20));
  CHECK(settings.exposures->first_layers == 4);
  REQUIRE(settings.display);
  CHECK_FALSE(settings.display->mirrors_known);
  DisplayGeometry mirrored = kPlatePanel;
  mirrored.mirror_x = true;
  const auto stack = opened.read(mirrored);
  Mask drawn(Pixels{12}, Pixels{8});
  for (std::int64_t layer = 0; layer < 3; ++layer) {
    stack->draw(settings.layer_height * layer, drawn);
    CHECK(drawn.row(0)[0] == layer + 1);
    CHECK(drawn.row(5)[3] == 255);
  }
}

TEST_CASE("A plate for another display is refused, but not one whose pixels were rounded to micrometres") {
  CHECK(testing::lacking(plate_refusal(plate(), {Pixels{8}, Pixels{12}, Micrometers{50}}), {"12x8", "8x12"})
            .empty());
  CHECK(testing::lacking(plate_refusal(plate(), {Pixels{12}, Pixels{8}, Micrometers{52}}), {"50.00", "52.00"})
            .empty());
  CHECK(plate_refusal(plate(), {Pixels{12}, Pixels{8}, Micrometers{50.45}}).empty());
  NanodlpTexts texts = kPlateTexts;
  texts.options = R"({"PWidth": 13, "PHeight": 8, "XPixelSize": 0.05, "YPixelSize": 0.05, "Thickness": 50})";
  CHECK(testing::lacking(plate_refusal(plate(texts)), {"options.json", "13x8", "12x8"}).empty());
}

TEST_CASE("The settings of a plate have defaults, and wrong ones are refused with their place") {
  NanodlpTexts texts = kPlateTexts;
  texts.options = "";
  texts.profile = R"({"Depth": 25})";
  const SlicedSettings settings = read_nanodlp_settings(texts);
  CHECK(settings.layer_height == Nanometers{25'000});
  CHECK(settings.first_layer == Nanometers{25'000});
  CHECK_FALSE(settings.exposures);
  CHECK_FALSE(settings.display);
  for (const auto& [profile, words] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"{}", {"thickness"}},
           {"[]", {"profile.json", "damaged"}},
           {"{", {"profile.json", "damaged"}},
           {R"({"Depth": -5})", {"Depth", "-5"}},
           {R"({"Depth": 1e9})", {"Depth", "1000"}},
           {R"({"Depth": "50"})", {"Depth", "no number"}},
           {R"({"Depth": 50, "CureTime": [2]})", {"CureTime", "no number"}},
           {R"({"Depth": null})", {"thickness"}}}) {
    texts.profile = profile;
    const std::string why = testing::message_of<ModelError>([&] { (void)read_nanodlp_settings(texts); });
    for (const std::string& word : words)
      CHECK(why.find(word) != std::string::npos);
  }
}

TEST_CASE("A plate without one of its pictures, with two of a layer or with one too many is refused") {
  std::vector<testing::PackedFile> files = plate();
  std::erase_if(files, [](const testing::PackedFile& file) { return file.name == "2.png"; });
  CHECK(testing::lacking(plate_refusal(files), {"2.png", "missing"}).empty());
  files = plate();
  std::erase_if(files, [](const testing::PackedFile& file) { return file.name == "3.png"; });
  CHECK(testing::lacking(plate_refusal(files), {"plate.json names 3 layers", "of 2"}).empty());
  files = plate();  // as if left by an earlier, longer plate
  files.push_back({"4.png", plate_picture(4)});
  CHECK(testing::lacking(plate_refusal(files), {"plate.json names 3 layers", "of 4"}).empty());
  files = plate();
  files.back().content = plate_picture(3, 11);
  CHECK(testing::lacking(plate_refusal(files), {"3.png", "11x8"}).empty());
  // Such files are no layers.
  files = plate();
  files.push_back({"04.png", "x"});
  files.push_back({"folder/4.png", "x"});
  files.push_back({"4.png.png", "x"});
  CHECK(plate_refusal(files).empty());
}
