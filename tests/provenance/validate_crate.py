"""Validates run directories as Provenance Run Crates with roc-validator, without a network.

    python validate_crate.py DIRECTORY...          in an environment that has roc-validator (requirements.txt)

Prints one line per issue, "SEVERITY CHECK MESSAGE"; exit status 1 when a required property is missing. The two JSON-LD contexts
that a crate names are given here, as far as our crates use them: most terms are schema.org's, the others are listed.
"""

import sys

from rdflib.plugins.shared.jsonld import context as jsonld_context
from rdflib.plugins.shared.jsonld import util as jsonld_util
from rocrate_validator import models, services
from rocrate_validator.utils import document_loader

SCHEMA = "http://schema.org/"
BIOSCHEMAS = "https://bioschemas.org/"
WORKFLOW_RUN = "https://w3id.org/ro/terms/workflow-run#"
CONTEXTS = {
    "https://w3id.org/ro/crate/1.1/context": {"@context": {
        "@vocab": SCHEMA,
        "File": SCHEMA + "MediaObject",
        "conformsTo": "http://purl.org/dc/terms/conformsTo",
        "ComputationalWorkflow": BIOSCHEMAS + "ComputationalWorkflow",
        "FormalParameter": BIOSCHEMAS + "FormalParameter",
        "input": BIOSCHEMAS + "ComputationalWorkflow#input",
        "output": BIOSCHEMAS + "ComputationalWorkflow#output",
    }},
    "https://w3id.org/ro/terms/workflow-run/context": {"@context": {"sha256": WORKFLOW_RUN + "sha256"}},
}


def local_document(source, fragment_id=None, extract_all_scripts=False):
    if isinstance(source, str) and source in CONTEXTS:
        return CONTEXTS[source], None
    return original(source, fragment_id, extract_all_scripts)


document_loader.install_document_loader()
original = jsonld_util.source_to_json
jsonld_util.source_to_json = jsonld_context.source_to_json = local_document
document_loader._fetch_json_ld = lambda url: CONTEXTS[url]

required = False
for directory in sys.argv[1:]:
    settings = services.ValidationSettings(
        rocrate_uri=directory, profile_identifier="provenance-run-crate-0.5", requirement_severity=models.Severity.RECOMMENDED,
        abort_on_first=False)
    for issue in services.validate(settings).get_issues():
        required |= issue.severity == models.Severity.REQUIRED
        print(issue.severity.name, issue.check.identifier, issue.message.replace("\n", " "))
sys.exit(1 if required else 0)
