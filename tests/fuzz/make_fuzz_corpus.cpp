// Writes the initial inputs of the fuzzers: make-fuzz-corpus FOLDER (with a folder for each target in it).
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "hw/png_file.hpp"
#include "tests/daemon/formats/packed_models.hpp"
#include "tests/fuzz/mask_input.hpp"
#include "tests/fuzz/odd_json.hpp"
#include "tests/models/damage.hpp"

namespace {

using namespace contourd;
namespace fs = std::filesystem;

void write(const fs::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

void write(const fs::path& path, const std::string& text) {
  write(path, std::as_bytes(std::span(text)));
}

models::Facets cracked_ball() {
  models::Facets facets = models::sphere(4, 6);
  models::Dice dice(1);
  models::drop_facets(facets, 0.05, dice);
  models::shake_corners(facets, 0.02, dice);
  return facets;
}

models::Facets extremes() {
  constexpr float kHuge = 3e38F, kTiny = 1e-45F;
  return {{{Vertex{-kHuge, -kHuge, -kHuge}, Vertex{kHuge, -kHuge, 0}, Vertex{0, kHuge, kHuge}}},
          {{Vertex{0, 0, -kTiny}, Vertex{kTiny, 0, kTiny}, Vertex{0, kTiny, 0}}},
          {{Vertex{1, 2, 3}, Vertex{1, 2, 3}, Vertex{-0.0F, 1e38F, 3}}}};
}

// Writes a sound ASCII file with each odd number in place of one of its coordinates.
void write_odd_numbers(const fs::path& folder, const std::string& sound) {
  int number = 0;
  std::size_t place = sound.find("vertex ");
  for (const char* odd : {"nan", "-nan(ind)", "inf", "-infinity", "1.#INF", "1e999", "1e-999", "1e39", "-0",
                          "1e", "+-1", "0x1p3", "1,5", "", "1 2"}) {
    write(folder / ("ascii_number" + std::to_string(number++)),
          sound.substr(0, place + 7) + odd + sound.substr(sound.find(' ', place + 7)));
    place = sound.find("vertex ", place + 1);
  }
}

void write_model_inputs(const fs::path& folder) {
  const models::Facets box = models::box({0, 0, 0}, {1, 2, 3});
  const std::string text = models::to_ascii_stl(box);
  write(folder / "box.stl", models::to_binary_stl(box));
  write(folder / "none.stl", models::to_binary_stl({}));
  write(folder / "extremes.stl", models::to_binary_stl(extremes()));
  write(folder / "ascii.stl", text);
  write_odd_numbers(folder, text);
  write(folder / "ascii_extremes.stl", models::to_ascii_stl(extremes()));
  write(folder / "ascii_cut.stl", text.substr(0, text.size() / 2));
  write(folder / "ascii_twice.stl", "; a comment\r\n" + text + text);
  write(folder / "no_number.stl",
        std::string(
            "SOLID x\nFACET NORMAL nan inf -1e999\nOUTER LOOP\nVERTEX 1e38 -1e-45 +.5\nVERTEX 0x1 1 1\n"));
  write(folder / "box.obj", std::string("# OBJ\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 0.2 1e0\nv 0 1 0\n"
                                        "f 1//2 2/3 3 4 5\nf -1 \\\n-2 -4\n"));
  // Binary files with a wrong count, and with a beginning that claims ASCII.
  auto bytes = models::to_binary_stl(box);
  bytes[80] = std::byte{200};
  write(folder / "wrong_count.stl", bytes);
  bytes = models::to_binary_stl(box);
  std::memcpy(bytes.data(), "solid", 5);
  write(folder / "binary_solid.stl", bytes);
}

void write_packed_inputs(const fs::path& folder) {
  const models::Facets box = models::box({0, 0, 0}, {1, 2, 3});
  const std::string stl = testing::stl_text(box);
  write(folder / "box.stl.gz", testing::gzipped(stl));
  write(folder / "box.zip", testing::zipped({{"a/box.stl", stl}, {"__MACOSX/x", ""}}));
  write(folder / "several.zip", testing::zipped({{"a.stl", stl}, {"b.stl", models::to_ascii_stl(box)}}));
  write(folder / "versions.zip",
        testing::zipped(
            {{"Supported/a.stl", stl}, {"Unsupported/a.stl", stl}, {"a.obj", "x"}, {"a.lys", "x"}}));
  write(folder / "box.amf",
        "<amf unit=\"inch\"><object id=\"1\"><mesh><vertices><vertex><coordinates><x>0</x><y>0</y><z>0</z>"
        "</coordinates></vertex><vertex><coordinates><x>1</x><y>0</y><z>0</z></coordinates></vertex><vertex>"
        "<coordinates><x>0</x><y>1</y><z>1</z></coordinates></vertex></vertices><volume><triangle><v1>0</v1>"
        "<v2>1</v2><v3>2</v3></triangle></volume></mesh></object><constellation id=\"2\"><instance "
        "objectid=\"1\"><deltax>1</deltax><rz>90</rz></instance></constellation></amf>");
  Mask picture(Pixels{8}, Pixels{6});
  picture.row(2)[3] = 200;
  const std::vector<std::uint8_t> png = encode_png(picture);
  const std::string text(png.begin(), png.end());
  write(folder / "layers.sl1",
        testing::zipped({{"config.ini", "layerHeight = 0.05\njobDir = a\nexpTime = 2\nexpTimeFirst = 9\n"},
                         {"prusaslicer.ini",
                          "display_pixels_x = 8\ndisplay_pixels_y = 6\ndisplay_width = 0.4\ndisplay_height = "
                          "0.3\ndisplay_mirror_x = 1\n"},
                         {"a00000.png", text},
                         {"a00001.png", text}}));
  write(folder / "plate.nanodlp",
        testing::zipped(
            {{"plate.json", R"({"LayersCount": 2})"},
             {"profile.json", R"({"Depth": 50, "CureTime": 2.5, "SupportLayerNumber": 1})"},
             {"options.json", R"({"PWidth": 8, "PHeight": 6, "XPixelSize": 0.05, "YPixelSize": 0.05})"},
             {"1.png", text},
             {"2.png", text}}));
  const std::string outlines =
      "<?xml version=\"1.0\" standalone=\"yes\"?><!DOCTYPE svg PUBLIC \"a\" \"b\"><svg width=\"0.4mm\" "
      "height=\"0.3mm\" "
      "viewBox=\"0 "
      "0 400 300\" xmlns=\"http://www.w3.org/2000/svg\"><path d=\"M 10 20 l 200 0 0 200 -200 0 z\"/>"
      "<path d=\"M 300 10 H 390 V 90 L 20 30 Z\"/></svg>";
  write(folder / "layers.sl1_svg", testing::zipped({{"config.ini", "layerHeight = 0.05\njobDir = a\n"},
                                                    {"a00000.svg", outlines},
                                                    {"a00001.svg", outlines}}));
  write(folder / "nested.zip", testing::zipped({{"a.3mf", testing::threemf_of(box)}, {"b\\c.stl", stl}}));
  write(folder / "locked.zip", testing::zipped({{"a.stl", stl, false, "secret"}, {"l.stl", "a.stl", true}}));
  write(folder / "box.3mf", testing::threemf_of(box));
}

void write_threemf_inputs(const fs::path& folder) {
  const models::Facets box = models::box({0, 0, 0}, {1, 2, 3});
  const std::string item = "<item objectid=\"1\" transform=\"1 0 0 0 -1 0 0 0 1 5 6 7\"/>";
  const std::string sound = testing::threemf_part(testing::threemf_object(1, box), item);
  write(folder / "box", sound);
  write(folder / "modifier",
        sound + std::string(1, '\0') +
            "<config><object id=\"1\"><part id=\"1\" subtype=\"modifier_part\"/><volume firstid=\"0\" "
            "lastid=\"3\"><metadata type=\"volume\" key=\"volume_type\" value=\"NegativeVolume\"/></volume>"
            "</object></config>");
  write(folder / "assembly",
        testing::threemf_part(
            testing::threemf_object(1, box) +
                testing::threemf_assembly(2, "<component objectid=\"1\"/><component objectid=\"1\"/>"),
            "<item objectid=\"2\" printable=\"0\"/><item objectid=\"2\"/>",
            "unit=\"inch\" requiredextensions=\"p\""));
}

void write_mask_inputs(const fs::path& folder) {
  const fuzz::MaskSettings grey{99, 79, fuzz::kGrey, 30'000, 50, 1};
  const fuzz::MaskSettings one_bit{99, 79, fuzz::kMirrorX | fuzz::kCopies, 40'000, 100, 2};
  const fuzz::MaskSettings one_pixel{0, 0, fuzz::kGrey | fuzz::kFit, 10'000, 50, 0};
  const fuzz::MaskSettings grown{99, 79, fuzz::kGrey | 12U << 8U, 30'000, 50, 1};
  const fuzz::MaskSettings shrunk{99, 79, 250U << 8U, 30'000, 50, 1};
  const fuzz::MaskSettings long_one{16383,  2, fuzz::kGrey | fuzz::kLongDisplay | fuzz::kMirrorY,
                                    60'000, 5, 0};
  const std::pair<const char*, models::Facets> shapes[] = {{"box", models::box({0, 0, 0}, {1, 2, 3})},
                                                           {"ball", models::sphere(2, 4)},
                                                           {"cracked", cracked_ball()},
                                                           {"extremes", extremes()}};
  for (const auto& [name, facets] : shapes) {
    int number = 0;
    for (const fuzz::MaskSettings& settings : {grey, one_bit, one_pixel, grown, shrunk, long_one}) {
      write(folder / (std::string(name) + std::to_string(number++)), fuzz::to_bytes({settings, facets}));
    }
  }
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Writes a sound text of JSON in its odd variants, each after the bytes that choose the reader.
void write_odd_json(const fs::path& name, const std::string& before, const std::string& sound) {
  int number = 0;
  for (const std::string& text : fuzz::odd_variants(sound))
    write(name.string() + "_" + std::to_string(number++), before + text);
}

void write_all_in(const fs::path& config, const fs::path& folder, char kind) {
  for (const fs::directory_entry& entry : fs::directory_iterator(config))
    write(folder / entry.path().filename(), kind + text_of(entry.path()));
}

void write_config_inputs(const fs::path& folder) {
  const fs::path config = CONTOURD_CONFIG_DIR;
  for (const char* name : {"contourd.json", "simulated.json", "raspberry-pi-4.json"})
    write(folder / name, "c" + text_of(config / name));
  write_all_in(config / "resins", folder, 'r');
  write_all_in(config / "projectors", folder, 't');
  write_odd_json(folder / "odd_printer", "c", text_of(config / "contourd.json"));
  write_odd_json(folder / "odd_resin", "r", text_of(config / "resins/standard.json"));
  write_odd_json(folder / "odd_table", "t", text_of(config / "projectors/optoma.json"));
  write(folder / "line",
        R"(c{"hardware": "real", "projector": {"light": {"chip": "gpiochip0", "line": 5}}})");
  write(
      folder / "noise",
      R"(t{"brand": "a", "source": "b", "notes": "c", "baud": 9600, "timeout_ms": 1000, "retries": 2, "gap_ms": 100,
 "warm_up_s": 1, "commands": {"power_on": {"text": "1", "accepted": "P"}, "power_off": {"text": "2", "accepted": "P"},
 "light_on": {"text": "3", "accepted": "P"}, "light_off": {"text": "4", "accepted": ".*"}}})");
  write(folder / "curve", R"(r{"layer_height_um": 50, "layer_height_min_um": 20, "layer_height_max_um": 100,
 "bottom_layers": 4, "fade_layers": 2, "lift_mm": 5, "lift_speed_mm_s": 1, "retract_speed_mm_s": 2.5, "second_lift_mm": 2,
 "settle_ms": 500, "rest_ms": 0, "working_curve": {"penetration_depth_um": 120, "critical_energy_mj_cm2": 8,
 "overcure_um": 60, "bottom_overcure_um": 150}})");
}

void write_ticket_inputs(const fs::path& folder) {
  write_odd_json(folder / "odd", "t",
                 R"({"resin": "standard", "adaptive_layers": {"cusp_um": 15, "min_um": 20, "max_um": 90},
 "unit": "mm", "up": {"x": 0.5, "y": 0, "z": 1}, "scale": {"x": 2}, "position_mm": {"x": -5, "y": 3}, "copies": 4,
 "drain": [{"position_mm": {"x": 1}, "direction": {"y": -1, "z": 0}, "diameter_mm": 2}]})");
  write_odd_json(folder / "odd_plate", "p",
                 R"({"resin": "standard", "layer_height_um": 50, "models": [{"file": "a.stl", "copies": 3,
 "rotation_deg": {"z": 45}}, {"file": "b.stl", "unit": "inch", "scale": 0.1}]})");
  write(folder / "two_sizes", R"(t{"fit": true, "scale": {"x": 2}})");
  write(folder / "no_direction", R"(p{"models": [{"file": "a.stl", "up": {}}]})");
  write(folder / "empty", std::string("t{}"));
  write(folder / "turned",
        R"(t{"resin": "standard", "layer_height_um": 50, "rotation_deg": {"x": 90}, "scale": 0.5,
 "position_mm": {"x": -5, "y": 3}, "copies": 4, "cracks": "refuse"})");
  write(folder / "up",
        R"(t{"adaptive_layers": {"cusp_um": 15, "min_um": 20, "max_um": 90}, "up": {"x": 1, "z": -1},
 "scale": {"x": 1.01, "y": 1, "z": 2}})");
  write(folder / "both",
        R"(t{"up": {"z": 0}, "rotation_deg": {}, "fit": true, "scale": 2, "copies": 1, "copies": 2})");
  write(folder / "turned_round", R"(t{"adaptive_layers": {"cusp_um": 15, "min_um": 90, "max_um": 20}})");
  write(folder / "keep_clean", R"(t{"up": "auto", "keep_clean": [{"z": -1}, {"x": 0, "y": 0},
 {"min": {"x": 0, "y": -1, "z": 0}, "max": {"x": 4, "y": 1, "z": 0}}]})");
  write(
      folder / "drain",
      R"(t{"drain": [{"position_mm": {"x": 1, "z": -2}, "direction": {"y": -1}, "diameter_mm": 2, "depth_mm": 3}]})");
  write(folder / "plate",
        R"(p{"resin": "standard", "models": [{"file": "a.stl", "fit": true}, {"file": "b.stl",
 "copies": 3, "rotation_deg": {"z": 45}}]})");
}

void write_job_inputs(const fs::path& folder) {
  models::Dice dice(1);
  for (int i = 0; i < 40; ++i) {
    std::string choices;
    while (choices.size() < 100)
      choices += static_cast<char>(dice.roll() % 256);
    write(folder / std::to_string(i), choices);
  }
  // The printer's settings, a ticket as text for a model, and the number of the model.
  const std::string box = std::string("\x04\xF0", 2) + '\0';
  write_odd_json(
      folder / "odd", box,
      R"({"layer_height_um": 50, "up": {"x": 0.5, "y": 0, "z": 1}, "scale": {"x": 2, "y": 1, "z": 1}, "unit": "mm"})");
  write(folder / "unit", box + R"({"unit": "inch", "scale": 0.1})");
  write(folder / "in-the-file", box + R"({"up": "auto", "fit": true, "supports": "in the file"})");
  write(folder / "auto", box + R"({"up": "auto", "keep_clean": [{"z": 1}], "supports": {"lift_mm": 3}})");
  write(folder / "no_direction", box + R"({"up": {"y": 0}})");
  write(folder / "plate", "\x04\xF1" + std::string(R"({"models": [{"file": "ball.stl", "copies": 2},
 {"file": "shell.stl", "position_mm": {"x": 5}}]})"));
}

void write_control_inputs(const fs::path& folder) {
  const std::string request = R"({"jsonrpc":"2.0","method":")", id = R"(","id":1})";
  for (const char* method : {"status", "pause", "fail", "watch", "none"})
    write(folder / method, "\x80" + request + method + id + "\r\n");
  write_odd_json(folder / "odd", "\x80",
                 R"({"jsonrpc": "2.0", "method": "echo", "params": {"value": "a", "other": 0.5}, "id": 1})");
  write(folder / "echo",
        "\x40" + request + R"(echo","params":{"value":"\u00e9","other":0.5},"id":"x"})" + "\n");
  write(folder / "set",
        "\x41" + request + R"(set","params":[1],"id":null})" + "\n" + request + R"(set"})" + "\n");
  write(folder / "batch", "\x80[" + request + "status" + id + "," + request + R"(status"},7,)" + request +
                              "echo" + id + "]\n[]\n");
  write(folder / "types",
        "\x80"
        R"({"jsonrpc":"2.0","method":7,"id":1})"
        "\n"
        R"({"jsonrpc":2,"method":"status","id":1})"
        "\n" +
            request + R"(echo","params":7,"id":{}})" + "\n");
  write(folder / "too_long", "\x41" + request + "status" + id);
  write(folder / "broken", std::string("\x10{\n\n[[[[\n\"\\ud800\"\n{\"id\":[]}\n\xff\n"));
}

// Bytes that the projector sends in serial_fuzz: at once, or after a message was sent to it.
std::string says(const std::string& bytes) {
  return "r" + std::string(1, static_cast<char>(bytes.size())) + bytes;
}
std::string answers(const std::string& bytes) {
  return "R" + std::string(1, static_cast<char>(bytes.size())) + bytes;
}

// The number of a table and its projector's replies for yes, off and on (empty if the table has no such
// question).
struct Language {
  char table;
  std::string yes, off, on;
};

// Power on, a light, darkness, power off.
std::string a_print(const Language& language) {
  const auto [table, yes, off, on] = language;
  const std::string lit = 'o' + answers(yes), dark = 'd' + ('f' + answers(yes));
  const std::string is_off = off.empty() ? "" : answers(off), is_on = on.empty() ? "" : answers(on);
  return table + ('p' + is_off) + answers(yes) + answers(yes) + is_on + answers(yes) + 't' + lit + 't' +
         dark + "tts" + is_on + lit + dark + 'x' + answers(yes) + answers(yes) + is_off + 'T';
}

void write_serial_inputs(const fs::path& folder) {
  using namespace std::string_literals;
  const Language text{0, "P\r", "OK0\r", "OK1\r"};
  write(folder / "text", a_print(text));
  write(folder / "bytes", a_print({1, "\x03\x14\x00\x00\x00\x14"s, "\x05\x14\x00\x03\x00\x00\x00\x00\x17"s,
                                   "\x05\x14\x00\x03\x00\x00\x00\x01\x18"s}));
  write(folder / "optoma", a_print({2, "P\r", "OK0\r", "OK1\r"}));
  write(folder / "anhua", a_print({3, "*\xFA\0\r"s, "", ""}));
  write(folder / "acer", a_print({6, "*000\r", "Lamp 0\r", "Lamp 1\r"}));
  const std::string on = "\0p"s + answers("OK1\r") + answers("P\r") + "t";
  write(folder / "refused",
        on + 'o' + answers("F\r") + answers("F\r") + answers("OK1\r") + "TfTdT" + says("INFO4\r"));
  write(folder / "whether_lit",
        on + "ottt" + answers("OK0\r") + 'd' + 'f' + answers("F\r") + answers("OK0\r") + 'T');
  write(folder / "half_a_reply",
        "\0mp"s + answers("P\r") + "tTtp" + answers("OK1\r") + says("P") + answers("") + 'T');
  write(folder / "silent", on + "oTTfdTTxTTu");
  write(folder / "gone", on + 'o' + answers("P\r") + says("INFO2\r") + "TudpT");
  write(folder / "left", "\0mc"s + answers("P\r") + "tT" + 'p' + answers("OK1\r") + says("P\r") + 'T');
  write(folder / "noise", "\1pt"s + says("\x03\x14\x03\x14\0\0"s) + 'f' + says("\0\0\x14"s) + 'T');
}

void write_record_inputs(const fs::path& folder) {
  using namespace std::string_literals;
  write(folder / "occupied", std::string("opart\n"));
  write(folder / "held", std::string("hpart failed: the lid is open\nand more"));
  const std::string rest =
      "\0part.stl\0"
      "17 17:684:5\0"
      "5\0fhn\0"s;
  for (const std::string end : {"done", "cancelled", "failed"})
    for (const std::string kind : {"printed", "refused", "interrupted", "unknown"})
      write(folder / (end + "_" + kind), "e7\0part\0"s + end +
                                             "\0it is full\0"
                                             "1700000000000\0"s +
                                             kind + rest);
  write(folder / "no_key",
        "e0\0part\0done\0\0"
        "0\0printed"s +
            rest);
  write(folder / "copied", std::string("c@\n17 17:684:5\ncopying 17 @\n"));
  write(folder / "copying", std::string("ccopying 99 99 99:684:5\n"));
  write(folder / "reading", std::string("r@\n@\n17 17:684:5"));
  const std::string light = R"({"light": {"chip": "gpiochip0", "line": 5, "active_low": false},
 "port": "/dev/ttyUSB0", "table": )" +
                            text_of(fs::path(CONTOURD_CONFIG_DIR) / "projectors/optoma.json") + "}";
  write(folder / "light", "l" + light);
  write_odd_json(folder / "odd_light", "l", light);
  write(folder / "printing",
        std::string("ppart.stl\nppart.json\nPplate\niother.json\npother.stl\npnotes.txt\nplost.json\n"
                    "dlost.stl\nilost.stl\nfnotes.txt\nfother.stl\n"));
  const std::string place =
      "\npart\n200\n1 2 3\n4\n5000\n1700000000000\n4\n12\n600000\n50000\n2500000000\n0\n0\n1\n600000\n"
      "5600000\n1\n";
  write(folder / "place", "s1" + place + "0\n0\n#2" + place + "8\n110\n5\n1\n1\n0\n40\n50\n4\n2\n0\n3\n");
  write(folder / "place_alone", "s7" + place + "0\n1\n2\n#");
  write(folder / "place_of_a_version", std::string("gcontourd-progress 2 "));
}

// Requests of other print hosts' clients to contourd-web. The job and the resin of the fake printer are
// called a, whose number is 1678518572 (FNV-1a).
void write_host_inputs(const fs::path& folder) {
  const std::string host = " HTTP/1.1\r\nHost: printer\r\n";
  const auto form = [](const std::string& key, const std::string& more, const std::string& content) {
    return "--x\r\nContent-Disposition: form-data; name=\"" + key + "\"" + more + "\r\n\r\n" + content +
           "\r\n";
  };
  const auto send = [&](const std::string& name, char server, const std::string& request,
                        const std::string& body = "") {
    const std::string head = body.empty() ? "" : "Content-Type: multipart/form-data; boundary=x\r\n";
    write(folder / name, server + request + host + head + "Content-Length: " + std::to_string(body.size()) +
                             "\r\n\r\n" + body);
  };
  constexpr char kNanodlp = '\x82', kOdyssey = '\x84';
  int number = 0;
  for (const char* path :
       {"status", "plates/list/json", "json/db/profiles.json", "json/db/machine.json",
        "printer/start/1678518572", "printer/force-stop", "printer/unpause", "plate/delete/1678518572",
        "static/plates/1678518572/3d.png", "static/plates/7/2.png", "z-axis/top"})
    send("nanodlp_" + std::to_string(number++), kNanodlp, std::string("GET /") + path);
  send("nanodlp_add", kNanodlp, "POST /plate/add",
       form("Path", "", "part") + form("ProfileID", "", "1678518572") +
           form("ZipFile", "; filename=\"part.nanodlp\"", "PK") + "--x--\r\n");
  send("nanodlp_usb", kNanodlp, "POST /plate/add",
       form("Path", "", "../part") + form("USBFile", "", "/etc/passwd") + "--x--\r\n");
  for (const char* request :
       {"GET /status", "GET /status/stream", "GET /files?location=Local&page_index=1&page_size=2",
        "GET /config", "GET /file/metadata?file_path=a.stl", "GET /file/thumbnail?file_path=a.stl&size=Small",
        "DELETE /file?file_path=../a.stl", "POST /print/start?file_path=a.stl", "POST /print/cancel",
        "POST /manual?z=1.0"})
    send("odyssey_" + std::to_string(number++), kOdyssey, request);
  send("odyssey_upload", kOdyssey, "POST /files",
       form("file", "; filename=\"a.stl\"", "solid x\nendsolid x\n") + "--x--\r\n");
}

// Requests of people, browsers and slicers to contourd-web, and what strangers try.
void write_web_inputs(const fs::path& folder) {
  write_host_inputs(folder);
  const std::string host = " HTTP/1.1\r\nHost: printer\r\n", end = "\r\n";
  const std::string key = host + "X-Api-Key: 00112233445566778899aabbccddeeff\r\n";
  const auto get = [&](const std::string& name, const std::string& path, const std::string& more = "") {
    write(folder / name, "\x80GET " + path + key + more + end);
  };
  const auto post = [&](const std::string& name, const std::string& path, const std::string& body,
                        const std::string& more = "") {
    write(folder / name, "\x80POST " + path + key + "Content-Length: " + std::to_string(body.size()) +
                             "\r\n" + more + end + body);
  };
  write(folder / "page", "\x80GET /" + host + end);
  write(folder / "stranger", "\x80GET /api/status HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  write(folder / "two", "\x80GET /base.js" + host + end + "HEAD /api/status" + key + end);
  int number = 0;
  for (const char* each : {"session", "status", "queue", "copies", "settings", "resins", "usage", "vat",
                           "mask", "events", "history?before=7", "version", "v1/storage", "nothing"})
    get("get_" + std::to_string(number++), std::string("/api/") + each);
  get("preview", "/api/preview?job=a%20b.stl");
  get("report", "/api/report?job=%00%ff");
  get("picture", "/api/picture?job=part&layer=12");
  get("film", "/api/time_lapse?job=part", "Range: bytes=0-1\r\n");
  get("film_end", "/api/time_lapse?job=part", "Range: bytes=-2\r\n");
  get("cookie", "/api/status", "Cookie: a=b; session=00; contourd=1\r\n");
  get("origin", "/api/status", "Origin: http://printer\r\nSec-Fetch-Site: same-origin\r\n");
  write(folder / "refused", "\x81GET /api/picture?job=part" + key + end);
  post("login", "/api/login", R"({"password": "correct horse"})");
  post("logout", "/api/logout", "");
  post("call", "/api/call/set", R"({"setting": "exposure", "value": 110})");
  post("service", "/api/call/home", "{}");
  post("upload", "/api/upload?name=part.stl&confirm=1", "solid x\nendsolid x\n");
  post("upload_long", "/api/upload?name=part.stl", std::string(2000, 'x'));
  post("form", "/api/files/local",
       "--x\r\nContent-Disposition: form-data; name=\"print\"\r\n\r\nfalse\r\n--x\r\nContent-Disposition: "
       "form-data; name=\"file\"; filename=\"a.stl\"\r\n\r\nsolid\r\n--x--\r\n",
       "Content-Type: multipart/form-data; boundary=x\r\nExpect: 100-continue\r\n");
  write(folder / "chunked", "\x80POST /api/upload?name=a.stl" + key + "Transfer-Encoding: chunked\r\n" + end +
                                "5\r\nsolid\r\n0\r\n\r\n");
  write(
      folder / "digest",
      "\x80GET /api/version" + host +
          "Authorization: Digest username=\"maker\", realm=\"contourd\", nonce=\"00\", uri=\"/api/version\", "
          "response=\"00112233445566778899aabbccddeeff\", algorithm=MD5, qop=auth, nc=00000001, "
          "cnonce=\"a\"\r\n" +
          end);
}

// Messages of a broker, see mqtt_fuzz.
void write_mqtt_inputs(const fs::path& folder) {
  const auto message = [](const std::string& topic, const std::string& payload) {
    return std::string{static_cast<char>(topic.size()), static_cast<char>(payload.size())} + topic + payload;
  };
  const std::string home = "contourd/contourd_1/command/";
  std::string all;
  for (const char* method : {"pause", "resume", "cancel", "plate_cleared"})
    all += message(home + method, "PRESS");
  using namespace std::string_literals;
  const std::string started = message("homeassistant/status", "online");
  write(folder / "commands", "\0"s + all);
  write(folder / "refused", "\1"s + all);
  write(folder / "kept", "\4"s + all + started);
  write(folder / "many", "\0"s + all + all + all + all);
  write(folder / "started", "\0"s + started + started + message("homeassistant/status", "offline"));
  write(folder / "strange", "\0"s + message(home + "home", "PRESS") + message(home + "pause", "press") +
                                message(home, "") + message("", "PRESS"));
  write(folder / "raw", "\2\x30\x0c\0\x05topicPRESS\xd0\0\x32\x07\0\1a\0\1b"s);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make-fuzz-corpus FOLDER\n", stderr);
    return 64;
  }
  try {
    const fs::path folder = argv[1];
    const std::pair<const char*, void (*)(const fs::path&)> targets[] = {
        {"model", write_model_inputs},     {"packed", write_packed_inputs},
        {"threemf", write_threemf_inputs}, {"mask", write_mask_inputs},
        {"config", write_config_inputs},   {"ticket", write_ticket_inputs},
        {"job", write_job_inputs},         {"control", write_control_inputs},
        {"serial", write_serial_inputs},   {"records", write_record_inputs},
        {"web", write_web_inputs},         {"mqtt", write_mqtt_inputs}};
    for (const auto& [target, write_inputs] : targets) {
      fs::create_directories(folder / target);
      write_inputs(folder / target);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make-fuzz-corpus: %s\n", error.what());
    return 73;
  }
}
