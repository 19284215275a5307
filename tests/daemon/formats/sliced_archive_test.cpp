#include "daemon/formats/sliced_archive.hpp"

#include <fmt/format.h>

#include "daemon/formats/model_input.hpp"
#include "hw/png_file.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/formats/packed_models.hpp"
#include "tests/message_of.hpp"

namespace {

constexpr std::uint64_t kEnough = std::uint64_t{1} << 30U;
const DisplayGeometry kPanel{Pixels{12}, Pixels{8}, Micrometers{50}};

// A picture in which each pixel is another one: its column times 20, plus its row.
Mask numbered(std::int32_t width, std::int32_t height, int layer = 0) {
  Mask mask(Pixels{width}, Pixels{height});
  for (std::int32_t y = 0; y < height; ++y)
    for (std::int32_t x = 0; x < width; ++x)
      mask.row(y)[static_cast<std::size_t>(x)] = static_cast<std::uint8_t>(20 * x + y + layer);
  return mask;
}

std::string png_text(const Mask& mask) {
  const std::vector<std::uint8_t> bytes = encode_png(mask);
  return {bytes.begin(), bytes.end()};
}

constexpr const char* kConfig =
    "action = print\njobDir = part\nlayerHeight = 0.05\nexpTime = 2.5\nexpTimeFirst=20\r\nnumFade = "
    "7\nnumFast = "
    "2\nnumSlow = 1\n";

std::string slicer_config(std::string_view more = "", std::array<int, 2> pixels = {12, 8}) {
  return fmt::format(
      "display_pixels_x = {}\ndisplay_pixels_y = {}\ndisplay_width = {}\ndisplay_height = {}\n{}", pixels[0],
      pixels[1], pixels[0] * 0.05, pixels[1] * 0.05, more);
}

std::vector<testing::PackedFile> three_layers(const Mask& first, const std::string& slicer) {
  std::vector<testing::PackedFile> files{{"config.ini", kConfig}, {"thumbnail/a00000.png", "x"}};
  if (!slicer.empty()) files.push_back({"prusaslicer.ini", slicer});
  for (int layer = 2; layer >= 0; --layer) {
    Mask picture = first;
    picture.row(0)[0] = static_cast<std::uint8_t>(layer);
    files.push_back({fmt::format("part{:05}.png", layer), png_text(picture)});
  }
  return files;
}

class OpenedArchive {
 public:
  explicit OpenedArchive(const std::vector<testing::PackedFile>& files)
      : opened_(open_models(folder_.write("any-name", testing::zipped(files)))) {}

  const SlicedArchive& archive() { return *opened_.models.front().input->sliced(); }

 private:
  testing::TemporaryFolder folder_;
  OpenedModels opened_;
};

Mask first_layer(const Mask& picture, const std::string& slicer, const DisplayGeometry& display = kPanel) {
  OpenedArchive opened(three_layers(picture, slicer));
  Mask drawn(display.width, display.height);
  opened.archive().read(display, kEnough, {})->draw(Nanometers{0}, drawn);
  return drawn;
}

}  // namespace

TEST_CASE("A sliced archive is recognised by its content and read in the order of its layers' numbers") {
  OpenedArchive opened(three_layers(numbered(12, 8), slicer_config()));
  const SlicedArchive& archive = opened.archive();
  CHECK(archive.layers() == 3);
  const SlicedSettings& settings = archive.settings();
  CHECK(settings.layer_height == Nanometers{50'000});
  REQUIRE(settings.exposures);
  CHECK(settings.exposures->normal == std::chrono::milliseconds(2500));
  CHECK(settings.exposures->first == std::chrono::seconds(20));
  CHECK(settings.exposures->fading == 7);
  const auto stack = archive.read(kPanel, kEnough, {});
  Mask drawn(Pixels{12}, Pixels{8});
  for (std::int64_t layer = 0; layer < 3; ++layer) {
    stack->draw(settings.layer_height * layer, drawn);
    CHECK(drawn.row(0)[0] == layer);
    CHECK(drawn.row(7)[11] == numbered(12, 8).row(7)[11]);
  }
}

TEST_CASE("The slicer's mirrors are undone, and the display's own ones applied") {
  const Mask on_plate = numbered(12, 8);
  const auto pixel = [](const Mask& mask, std::int32_t x, std::int32_t y) {
    return mask.row(y)[static_cast<std::size_t>(x)];
  };
  for (const bool sliced_x : {false, true}) {
    for (const bool own_x : {false, true}) {
      DisplayGeometry display = kPanel;
      display.mirror_x = own_x;
      const Mask drawn =
          first_layer(on_plate, slicer_config(sliced_x ? "display_mirror_x = 1" : ""), display);
      CHECK(pixel(drawn, sliced_x == own_x ? 3 : 8, 5) == pixel(on_plate, 3, 5));
    }
  }
  DisplayGeometry display = kPanel;
  display.mirror_y = true;
  CHECK(pixel(first_layer(on_plate, slicer_config(), display), 3, 2) == pixel(on_plate, 3, 5));
}

TEST_CASE("A display whose sides are exchanged gets the pictures turned by a quarter") {
  // As PrusaSlicer writes them for a display on end: x of the plate runs upwards, y to the left.
  Mask on_end(Pixels{8}, Pixels{12});
  const Mask on_plate = numbered(12, 8);
  for (std::int32_t row = 0; row < 12; ++row)
    for (std::int32_t column = 0; column < 8; ++column)
      on_end.row(row)[static_cast<std::size_t>(column)] =
          on_plate.row(column)[static_cast<std::size_t>(11 - row)];
  on_end.row(0)[0] = 1;
  const Mask turned_back = first_layer(on_end, slicer_config("display_orientation = portrait"));
  CHECK(turned_back.row(4)[7] == on_plate.row(4)[7]);
  CHECK(turned_back.row(7)[0] == on_plate.row(7)[0]);
  const DisplayGeometry upright{Pixels{8}, Pixels{12}, Micrometers{50}};
  // An upright display gets these pictures as they are, and turns those of a flat one as PrusaSlicer does.
  CHECK(first_layer(on_end, slicer_config("display_orientation = portrait"), upright).row(11)[3] ==
        on_plate.row(3)[0]);
  CHECK(first_layer(on_plate, slicer_config(), upright).row(11)[3] == on_plate.row(3)[0]);
}

TEST_CASE("Without prusaslicer.ini, pictures are as they are") {
  DisplayGeometry display = kPanel;
  display.mirror_x = true;
  CHECK(first_layer(numbered(12, 8), "", display).row(5)[3] == numbered(12, 8).row(5)[3]);
  CHECK(testing::lacking(testing::message_of<ModelError>([] { (void)first_layer(numbered(8, 12), ""); }),
                         {"8x12 pixels", "12x8"})
            .empty());
}

TEST_CASE("Pictures that need more memory than there is are refused, and a stop ends their reading") {
  OpenedArchive opened(three_layers(numbered(12, 8), slicer_config()));
  CHECK(
      testing::lacking(testing::message_of<ModelError>([&] { (void)opened.archive().read(kPanel, 100, {}); }),
                       {"memory", "print the model itself"})
          .empty());
  std::stop_source stop;
  stop.request_stop();
  CHECK(opened.archive().read(kPanel, kEnough, stop.get_token())->layers() == 0);
}

TEST_CASE("Pixels larger or smaller than the display's by more than half a percent are refused") {
  const auto refusal = [](double pitch_um) {
    DisplayGeometry display = kPanel;
    display.pixel_pitch = Micrometers{pitch_um};
    return testing::message_of<ModelError>(
        [&] { (void)first_layer(numbered(12, 8), slicer_config(), display); });
  };
  CHECK(refusal(50.2).empty());
  CHECK(refusal(49.8).empty());
  CHECK(testing::lacking(refusal(50.5), {"50.00 x 50.00 um", "50.50 um", "1.0 % too large"}).empty());
  CHECK(testing::lacking(refusal(49), {"2.0 % too small"}).empty());
}

TEST_CASE("A file that holds pictures is no model for those who need one") {
  const testing::TemporaryFolder folder;
  const auto input =
      open_model(folder.write("a", testing::zipped(three_layers(numbered(12, 8), slicer_config()))));
  CHECK(input->sliced() != nullptr);
  CHECK(testing::lacking(testing::message_of<ModelError>([&] { (void)input->read(100); }),
                         {"finished layers", "--printer"})
            .empty());
  const auto model = open_model(folder.write("b", testing::stl_text(models::sphere(4, 12))));
  CHECK(model->sliced() == nullptr);
}

TEST_CASE("An archive of models that has a config.ini, too, is an archive of models") {
  const testing::TemporaryFolder folder;
  const OpenedModels opened = open_models(folder.write(
      "a.zip", testing::zipped({{"config.ini", "x"}, {"a.stl", testing::stl_text(models::sphere(4, 12))}})));
  CHECK(opened.models.front().input->sliced() == nullptr);
}

TEST_CASE("A ticket that names a model of an archive without models is refused") {
  const testing::TemporaryFolder folder;
  CHECK(testing::lacking(
            testing::message_of<ModelError>([&] {
              (void)open_models(folder.write("a.zip", testing::zipped({{"readme.txt", "x"}})), {{"b.stl"}});
            }),
            {"no model", "b.stl"})
            .empty());
}
