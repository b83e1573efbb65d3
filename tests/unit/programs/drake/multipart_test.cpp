// Tests of the parser of multipart/form-data. The wanted parts are those of RFC 7578 and RFC 2046.
#include <gtest/gtest.h>

#include "programs/drake/http/multipart.h"

namespace fire3dv::drake {
namespace {

const std::string kMultipartType = "multipart/form-data; boundary=XyZ";

std::string field(const std::string& name, const std::string& value) {
  return "--XyZ\r\nContent-Disposition: form-data; name=\"" + name + "\"\r\n\r\n" + value + "\r\n";
}

std::string fault_of(const std::string& body, const std::string& type = kMultipartType) {
  const auto parts = parse_multipart(body, type);
  return parts ? "" : parts.error().message;
}

TEST(Multipart, ReadsPartsAsCurlWritesThem) {
  const std::string body =
      field("width", "640") + field("empty", "") +
      "--XyZ\r\nContent-Disposition: form-data; name=\"scene\"; filename=\"../../1.gltf\"\r\n"
      "Content-Type: model/gltf+json\r\n\r\n{\r\n--XyW\r\n}\r\n--XyZ--\r\n";
  const auto parts = parse_multipart(body, kMultipartType);
  ASSERT_TRUE(parts) << parts.error().message;
  ASSERT_EQ(parts->size(), 3u);
  EXPECT_EQ((*parts)[0].name, "width");
  EXPECT_EQ((*parts)[0].data, "640");
  EXPECT_FALSE((*parts)[0].is_file);
  EXPECT_EQ((*parts)[1].name, "empty");
  EXPECT_EQ((*parts)[1].data, "");
  EXPECT_EQ((*parts)[2].name, "scene");
  EXPECT_TRUE((*parts)[2].is_file);
  EXPECT_EQ((*parts)[2].data, "{\r\n--XyW\r\n}");  // a line that only resembles the boundary
}

TEST(Multipart, AcceptsWhatTheStandardAllows) {
  // Quoted boundary with a space, other case, a preamble, spaces behind the boundary, an epilogue.
  const auto parts = parse_multipart(
      "preamble\r\n--a b\t \r\ncontent-disposition:form-data;NAME=plain ; filename*=utf-8''x\r\n"
      "X: y\r\n\r\n1\r\n"
      "--a b\r\nContent-Disposition: form-data; name=\"a\\\"b\"\r\n\r\n2\r\n--a b--epilogue",
      "Multipart/Form-Data; charset=utf-8; Boundary=\"a b\"");
  ASSERT_TRUE(parts) << parts.error().message;
  ASSERT_EQ(parts->size(), 2u);
  EXPECT_EQ((*parts)[0].name, "plain");
  EXPECT_EQ((*parts)[0].data, "1");
  EXPECT_EQ((*parts)[1].name, "a\"b");
  const auto none = parse_multipart("--XyZ--", kMultipartType);
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->empty());
}

TEST(Multipart, RefusesAnotherType) {
  const std::string body = field("a", "1") + "--XyZ--\r\n";
  EXPECT_NE(fault_of(body, "").find("must be multipart/form-data"), std::string::npos);
  EXPECT_NE(fault_of(body, "text/plain; boundary=XyZ").find("must be"), std::string::npos);
  for (const char* type :
       {"multipart/form-data", "multipart/form-data; boundary=", "multipart/form-data; xboundary=XyZ"})
    EXPECT_NE(fault_of(body, type).find("names no boundary"), std::string::npos) << type;
  EXPECT_NE(fault_of(body, "multipart/form-data; boundary=" + std::string(71, 'x')).find("boundary"),
            std::string::npos);
  EXPECT_NE(fault_of(body, "multipart/form-data; boundary=other").find("does not hold"), std::string::npos);
}

TEST(Multipart, RefusesEveryTruncation) {
  const std::string body = field("first", "1") + field("second", "22") + "--XyZ--";
  EXPECT_EQ(fault_of(body), "");
  for (size_t length = 0; length < body.size(); ++length)
    EXPECT_NE(fault_of(body.substr(0, length)), "") << body.substr(0, length);
}

TEST(Multipart, LimitsPartsAndHeaders) {
  std::string many;
  for (int i = 0; i < 64; ++i) many += field("n" + std::to_string(i), "v");
  EXPECT_EQ(fault_of(many + "--XyZ--"), "");
  EXPECT_NE(fault_of(many + field("more", "v") + "--XyZ--").find("more than 64 parts"), std::string::npos);
  const std::string headers = "--XyZ\r\nX: " + std::string(5000, 'x') +
                              "\r\nContent-Disposition: form-data; name=a\r\n\r\n1\r\n--XyZ--";
  EXPECT_NE(fault_of(headers).find("exceed 4096 bytes"), std::string::npos);
}

TEST(Multipart, NamesTheFaultOfAPart) {
  const auto part = [](const std::string& headers) { return "--XyZ\r\n" + headers + "\r\n\r\n1\r\n--XyZ--"; };
  EXPECT_NE(fault_of(part("Content-Disposition form-data")).find("without a colon"), std::string::npos);
  EXPECT_NE(fault_of(part("Content-Type: text/plain")).find("no Content-Disposition"), std::string::npos);
  EXPECT_NE(fault_of(part("Content-Disposition: attachment; name=a")).find("must be form-data"),
            std::string::npos);
  EXPECT_NE(fault_of(part("Content-Disposition: form-data; name=\"\"")).find("with a name"),
            std::string::npos);
  EXPECT_NE(fault_of("--XyZ\r\n\r\n\r\n--XyZ--").find("no Content-Disposition"), std::string::npos);
  EXPECT_NE(fault_of("--XyZjunk\r\n\r\n--XyZ--").find("a line break must follow"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::drake
