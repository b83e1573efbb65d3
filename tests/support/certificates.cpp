// Key and certificate generation, with OpenSSL.
#include "tests/support/certificates.h"

#include <openssl/pem.h>
#include <openssl/x509v3.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace fire3dv::test {
namespace {

using Key = std::unique_ptr<EVP_PKEY, decltype(&::EVP_PKEY_free)>;
using Certificate = std::unique_ptr<X509, decltype(&::X509_free)>;
struct CloseFile {
  void operator()(FILE* file) const { ::fclose(file); }
};
using File = std::unique_ptr<FILE, CloseFile>;

void add_extension(X509* certificate, X509* signer, int which, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, signer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = ::X509V3_EXT_conf_nid(nullptr, &context, which, value.c_str());
  if (extension == nullptr) std::abort();
  ::X509_add_ext(certificate, extension, -1);
  ::X509_EXTENSION_free(extension);
}

Certificate make(const std::string& name, EVP_PKEY* key, X509* signer) {
  static long serial = 1;
  Certificate certificate(::X509_new(), ::X509_free);
  ::X509_set_version(certificate.get(), 2);
  ::ASN1_INTEGER_set(::X509_get_serialNumber(certificate.get()), serial++);
  ::X509_gmtime_adj(::X509_getm_notBefore(certificate.get()), -60);
  ::X509_gmtime_adj(::X509_getm_notAfter(certificate.get()), 3600);
  ::X509_set_pubkey(certificate.get(), key);
  X509_NAME* subject = ::X509_get_subject_name(certificate.get());
  ::X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC,
                               reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  ::X509_set_issuer_name(certificate.get(),
                         ::X509_get_subject_name(signer != nullptr ? signer : certificate.get()));
  return certificate;
}

Credentials::Identity write(const std::filesystem::path& folder, const std::string& name, X509* certificate,
                            EVP_PKEY* key) {
  Credentials::Identity identity{(folder / (name + ".pem")).string(), (folder / (name + ".key")).string()};
  ::PEM_write_X509(File(::fopen(identity.certificate_file.c_str(), "w")).get(), certificate);
  ::PEM_write_PrivateKey(File(::fopen(identity.key_file.c_str(), "w")).get(), key, nullptr, nullptr, 0,
                         nullptr, nullptr);
  ::chmod(identity.key_file.c_str(), 0600);
  return identity;
}

}  // namespace

Credentials::Credentials() {
  std::string pattern = (std::filesystem::temp_directory_path() / "fire3dv-test-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) std::abort();
  folder_ = pattern;
}

Credentials::~Credentials() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

Credentials::Identity Credentials::authority(const std::string& name) const {
  const Key key(::EVP_EC_gen("P-256"), ::EVP_PKEY_free);
  const Certificate certificate = make(name, key.get(), nullptr);
  add_extension(certificate.get(), certificate.get(), NID_basic_constraints, "critical,CA:TRUE");
  ::X509_sign(certificate.get(), key.get(), ::EVP_sha256());
  return write(folder_, name, certificate.get(), key.get());
}

Credentials::Identity Credentials::identity(const std::string& name, const std::string& hosts,
                                            const Identity& signer) const {
  const Certificate authority(
      ::PEM_read_X509(File(::fopen(signer.certificate_file.c_str(), "r")).get(), nullptr, nullptr, nullptr),
      ::X509_free);
  const Key signing(
      ::PEM_read_PrivateKey(File(::fopen(signer.key_file.c_str(), "r")).get(), nullptr, nullptr, nullptr),
      ::EVP_PKEY_free);
  const Key key(::EVP_EC_gen("P-256"), ::EVP_PKEY_free);
  const Certificate certificate = make(name, key.get(), authority.get());
  add_extension(certificate.get(), authority.get(), NID_subject_alt_name, hosts);
  ::X509_sign(certificate.get(), signing.get(), ::EVP_sha256());
  return write(folder_, name, certificate.get(), key.get());
}

std::string Credentials::file(const std::string& name, const std::string& text, unsigned mode) const {
  const std::string path = (folder_ / name).string();
  std::ofstream(path) << text;
  ::chmod(path.c_str(), mode);
  return path;
}

std::string Credentials::key(const std::string& name, char digit) const {
  return file(name, std::string(64, digit) + "\n", 0600);
}

}  // namespace fire3dv::test
