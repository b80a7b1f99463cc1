// The attacks of S1 to S6: bytes of other files, connections, huge headers. Every driver of GDAL is
// registered here, VRT and HTTP too, so that the fence alone must hold.
#include "arete/raster/fence.h"

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <arpa/inet.h>
#include <cpl_conv.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "arete/core/error.h"
#include "arete/raster/dem.h"

#include "raster/grid_files.h"

namespace arete::raster {
namespace {

using namespace testing;  // NOLINT: the room's own helpers

constexpr int kSide = 64;
constexpr float kCanary = 'Z';
constexpr double kOwn = 7;

class FenceTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { GDALAllRegister(); }

  FenceTest() { write_text(dir_ / "canary.bin", std::string(kSide * kSide, 'Z')); }

  std::string raw_vrt() const {
    return fmt::format(
        "<VRTDataset rasterXSize=\"{0}\" rasterYSize=\"{0}\"><VRTRasterBand dataType=\"Byte\" "
        "band=\"1\" subClass=\"VRTRawRasterBand\"><SourceFilename relativeToVRT=\"0\">{1}"
        "</SourceFilename></VRTRasterBand></VRTDataset>",
        kSide / 2, (dir_ / "canary.bin").native());
  }

  // A GeoTIFF of kOwn whose metadata name `reference` as its overviews.
  std::filesystem::path with_overview(const std::string& name, const std::string& reference) {
    write_grid(dir_ / name, {.cols = kSide, .rows = kSide, .type = GDT_Byte, .values = {kOwn}});
    const GDALDatasetUniquePtr dataset(
        GDALDataset::Open((dir_ / name).c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
    dataset->SetMetadataItem("OVERVIEW_FILE", reference.c_str(), "OVERVIEWS");
    return dir_ / name;
  }

  // What a careless importer would do: opens anything and reads it at half size.
  static std::vector<std::uint8_t> careless_read(const std::filesystem::path& file) {
    std::vector<std::uint8_t> bytes(kSide / 2 * kSide / 2);
    CPLPushErrorHandler(CPLQuietErrorHandler);
    if (const GDALDatasetUniquePtr dataset(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER));
        dataset) {
      EXPECT_EQ(CE_None, dataset->GetRasterBand(1)->RasterIO(
                             GF_Read, 0, 0, dataset->GetRasterXSize(), dataset->GetRasterYSize(),
                             bytes.data(), kSide / 2, kSide / 2, GDT_Byte, 0, 0, nullptr));
    }
    CPLPopErrorHandler();
    return bytes;
  }

  static std::string refusal(const std::filesystem::path& file, const DemOptions& options = {}) {
    try {
      for (const float z : read_all(*open_dem({file}, options))) {
        if (z == kCanary) return "LEAKED";
      }
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

  TempDir dir_;
};

TEST_F(FenceTest, S1OverviewsInTheFileDoNotLeakAnotherFile) {
  const auto file = with_overview("s1.tif", raw_vrt());
  const auto careless = careless_read(file);
  ASSERT_EQ(careless.front(), 'Z') << "negative control: the attack no longer works";
  for (const char* crs : {"", "EPSG:4326"}) {
    for (const float z : read_all(*open_dem({file}, {.crs = crs}))) {
      EXPECT_TRUE(std::isnan(z) || z == kOwn) << z;
    }
  }
  const auto drape = open_drape(file, 10, 10, {});
  for (const std::uint8_t byte : drape->read({0, 0, 0}).bytes) ASSERT_NE(byte, 'Z');
}

TEST_F(FenceTest, S1SidecarsDoNotLeakAnotherFile) {
  write_grid(dir_ / "side.tif", {.cols = kSide, .rows = kSide, .type = GDT_Byte, .values = {kOwn}});
  write_text(dir_ / "side.tif.ovr", raw_vrt());
  write_text(dir_ / "side.tif.msk", raw_vrt());
  write_text(dir_ / "side.tif.aux.xml",
             "<PAMDataset><Metadata domain=\"OVERVIEWS\"><MDI key=\"OVERVIEW_FILE\">" +
                 (dir_ / "side.tif.ovr").native() + "</MDI></Metadata></PAMDataset>");
  for (const float z : read_all(*open_dem({dir_ / "side.tif"}))) EXPECT_EQ(z, kOwn);
}

// Masks within a GeoTIFF are read (dem_test), those beside it are any driver's to open.
TEST_F(FenceTest, S1MasksBesideTheFileAreNotOpened) {
  const auto file = dir_ / "dem.tif";
  write_grid(file, {.cols = kSide, .rows = kSide, .type = GDT_Byte, .values = {kOwn}});
  CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", "NO");
  CPLSetThreadLocalConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "NO");
  {
    const GDALDatasetUniquePtr beside(
        GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
    ASSERT_EQ(beside->CreateMaskBand(GMF_PER_DATASET), CE_None);
    beside->GetRasterBand(1)->GetMaskBand()->Fill(0);
  }
  {
    const GDALDatasetUniquePtr careless(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER));
    EXPECT_TRUE(file_mask(*careless, 1)) << "negative control";
  }
  CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", nullptr);
  CPLSetThreadLocalConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", nullptr);
  ASSERT_TRUE(std::filesystem::exists(dir_ / "dem.tif.msk"));
  for (const float z : read_all(*open_dem({file}))) EXPECT_EQ(z, kOwn);
}

// A socket that nobody should knock at.
class Listener {
 public:
  Listener() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const generic = reinterpret_cast<sockaddr*>(&address);
    if (::bind(socket_, generic, size) != 0 || ::listen(socket_, 8) != 0 ||
        ::getsockname(socket_, generic, &size) != 0) {
      ::close(socket_);
      socket_ = -1;
    }
    port_ = ntohs(address.sin_port);
  }
  ~Listener() { ::close(socket_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  bool works() const { return socket_ >= 0; }
  std::string url() const { return fmt::format("http://127.0.0.1:{}/x.tif", port_); }
  bool knocked() const {
    const int peer = ::accept(socket_, nullptr, nullptr);
    if (peer >= 0) ::close(peer);
    return peer >= 0;
  }

 private:
  int socket_;
  int port_ = 0;
};

TEST_F(FenceTest, S2OverviewsInTheFileDoNotConnect) {
  const Listener listener;
  if (!listener.works()) GTEST_SKIP() << "no loopback network here";
  for (const std::string& reference : {"/vsicurl/" + listener.url(), listener.url()}) {
    const auto file = with_overview("s2.tif", reference);
    EXPECT_EQ(refusal(file), "");
    EXPECT_EQ(refusal(file, {.crs = "EPSG:4326"}), "");
    open_drape(file, 10, 10, {});
    EXPECT_FALSE(listener.knocked()) << reference;
  }
  // Negative control: the same file without the fence's options.
  CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_EXTENSIONS", nullptr);
  CPLSetConfigOption("GDAL_HTTP_TIMEOUT", "1");
  careless_read(with_overview("s2c.tif", "/vsicurl/" + listener.url()));
  CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_EXTENSIONS", ".none");
  EXPECT_TRUE(listener.knocked()) << "negative control: the attack no longer works";
}

// The process gets at most `bytes` of anonymous memory while it lives; not under a sanitizer, whose
// shadow alone is more.
class DataLimit {
 public:
  explicit DataLimit(rlim_t bytes) {
    ::getrlimit(RLIMIT_DATA, &old_);
#ifndef __SANITIZE_ADDRESS__
    const rlimit limit{.rlim_cur = bytes, .rlim_max = old_.rlim_max};
    ::setrlimit(RLIMIT_DATA, &limit);
#else
    static_cast<void>(bytes);
#endif
  }
  ~DataLimit() {
    ::setrlimit(RLIMIT_DATA, &old_);
  }
  DataLimit(const DataLimit&) = delete;
  DataLimit& operator=(const DataLimit&) = delete;

 private:
  rlimit old_{};
};

// A little-endian TIFF of 100,000 x 100,000 samples, DEFLATE, and four bytes of them.
std::string bomb(std::uint32_t bits, bool tiled) {
  std::string tiff("II*\0\x08\0\0\0", 8);
  const auto put = [&](auto value) { tiff.append(reinterpret_cast<char*>(&value), sizeof value); };
  struct Entry {
    std::uint16_t tag;
    std::uint32_t value;
  };
  std::vector<Entry> entries{{256, 100000}, {257, 100000}, {258, bits}, {259, 8}, {262, 1}};
  if (tiled) {
    entries.insert(entries.end(), {{277, 1}, {322, 100000}, {323, 100000}, {324, 4}, {325, 4}});
  } else {
    entries.insert(entries.end(), {{273, 4}, {277, 1}, {278, 100000}, {279, 4}, {284, 1}});
  }
  put(static_cast<std::uint16_t>(entries.size()));
  for (const Entry& entry : entries) {
    put(entry.tag);
    put(std::uint16_t{4});
    put(std::uint32_t{1});
    put(entry.value);
  }
  put(std::uint32_t{0});
  return tiff;
}

TEST_F(FenceTest, S3HugeBlocksAreRefusedBeforeMemoryIsTaken) {
  for (const bool tiled : {false, true}) {
    for (const std::uint32_t bits : {8U, 16U}) {
      SCOPED_TRACE(fmt::format("{} bits, {}", bits, tiled ? "tiled" : "one strip"));
      write_text(dir_ / "bomb.tif", bomb(bits, tiled));
      EXPECT_EQ(std::filesystem::file_size(dir_ / "bomb.tif"), 134);
      const DataLimit limit(1U << 30U);
      const auto start = std::chrono::steady_clock::now();
      std::string text;
      try {
        const auto dem = open_dem({dir_ / "bomb.tif"});
        std::vector<float> row(100000);
        dem->read_row(0, row);
      } catch (const Error& error) {
        text = error.what();
      }
      EXPECT_NE(text, "");
      EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
    }
  }
}

TEST_F(FenceTest, S5ByReferenceFilesAndOddNamesAreRefused) {
  write_text(dir_ / "dem.tif", raw_vrt());
  EXPECT_EQ(careless_read(dir_ / "dem.tif").front(), 'Z') << "negative control";
  EXPECT_NE(refusal(dir_ / "dem.tif").find("no DEM format"), std::string::npos);
  for (const std::string& name :
       {raw_vrt(), std::string("/vsicurl/http://127.0.0.1:1/x.tif"), std::string("/vsimem/x.tif"),
        std::string("http://127.0.0.1:1/x.tif"), "/vsizip/" + (dir_ / "a.zip").native(),
        std::string("MEM:::DATAPOINTER=1,PIXELS=1,LINES=1"),
        "GTIFF_DIR:1:" + (dir_ / "dem.tif").native(),
        "NETCDF:\"" + (dir_ / "x.nc").native() + "\":z"}) {
    EXPECT_NE(refusal(name), "") << name;
    EXPECT_NE(refusal(name), "LEAKED") << name;
  }
}

TEST_F(FenceTest, PipesAreRefusedWithoutWaiting) {
  ASSERT_EQ(::mkfifo((dir_ / "pipe.tif").c_str(), 0600), 0);
  EXPECT_NE(refusal(dir_ / "pipe.tif").find("not a regular file"), std::string::npos);
}

TEST_F(FenceTest, LabelsMayNotReferToOtherFolders) {
  std::filesystem::create_directory(dir_ / "in");
  const auto label = [&](const std::string& target) {
    write_text(dir_ / "in" / "dem.lbl",
               fmt::format("PDS_VERSION_ID = PDS3\nRECORD_TYPE = FIXED_LENGTH\nRECORD_BYTES = 16\n"
                           "FILE_RECORDS = 4\n^IMAGE = (\"{}\",1)\nOBJECT = IMAGE\n  LINES = 4\n"
                           "  LINE_SAMPLES = 16\n  SAMPLE_TYPE = MSB_UNSIGNED_INTEGER\n"
                           "  SAMPLE_BITS = 8\n  BANDS = 1\nEND_OBJECT = IMAGE\nEND\n",
                           target));
    return dir_ / "in" / "dem.lbl";
  };
  for (const std::string& target : {std::string("../canary.bin"), (dir_ / "canary.bin").native()}) {
    const std::string text = refusal(label(target));
    EXPECT_NE(text, "");
    EXPECT_NE(text, "LEAKED");
  }
  write_text(dir_ / "in" / "dem.IMG", std::string(64, 'a'));
  for (const float z : read_all(*open_dem({label("dem.IMG")}))) EXPECT_EQ(z, 'a');
}

TEST_F(FenceTest, Hdf5ExternalStorageIsRefused) {
  const auto write = [&](const char* name, bool external) {
    const hid_t file = H5Fcreate((dir_ / name).c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hsize_t sides[2] = {kSide, kSide};
    const hid_t space = H5Screate_simple(2, sides, nullptr);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    if (external) {
      H5Pset_external(creation, (dir_ / "canary.bin").c_str(), 0, hsize_t{kSide} * kSide);
    }
    const hid_t group = H5Gcreate2(file, "g", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dclose(H5Dcreate2(file, "z", H5T_STD_U8LE, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    H5Gclose(group);
    H5Pclose(creation);
    H5Sclose(space);
    H5Fclose(file);
    return dir_ / name;
  };
  const std::string text = refusal(write("out.nc", true));
  EXPECT_NE(text.find("other files"), text.npos) << text;
  EXPECT_EQ(refusal(write("own.nc", false)), "");
  const hid_t file = H5Fcreate((dir_ / "link.nc").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_external((dir_ / "own.nc").c_str(), "/z", file, "z", H5P_DEFAULT, H5P_DEFAULT);
  H5Fclose(file);
  EXPECT_NE(refusal(dir_ / "link.nc").find("other files"), std::string::npos);
}

// netCDF would read its samples, but neither its place nor that its first row is the southern one.
TEST_F(FenceTest, BagsAreRefused) {
  const hid_t file = H5Fcreate((dir_ / "a.bag").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Gclose(H5Gcreate2(file, "BAG_root", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Fclose(file);
  EXPECT_NE(refusal(dir_ / "a.bag").find("a BAG"), std::string::npos);
}

TEST_F(FenceTest, NothingReachesStderr) {
  write_grid(dir_ / "cut.tif", {.cols = 99, .rows = 99, .options = {"COMPRESS=LZW"}});
  std::filesystem::resize_file(dir_ / "cut.tif", 900);
  write_text(dir_ / "junk.tif", std::string("II*\0\x08\0\0\0\xff\xff", 10));
  write_text(dir_ / "junk.nc", "CDF\x01 and no more");
  write_text(dir_ / "junk.png", "\x89PNG\r\n\x1a\n and no more");
  const CapturedStderr captured;
  for (const char* name : {"cut.tif", "junk.tif", "junk.nc", "junk.png"}) refusal(dir_ / name);
  EXPECT_EQ(captured.text(), "");
  static_cast<void>(::write(STDERR_FILENO, "x", 1));
  EXPECT_EQ(captured.text(), "x") << "negative control";
}

}  // namespace
}  // namespace arete::raster
