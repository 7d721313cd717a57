"""Validates run directories as Provenance Run Crates with roc-validator, without a network.

    python validate_crate.py DIRECTORY...          in an environment that has roc-validator (requirements.txt)

Prints one line per issue, "SEVERITY CHECK MESSAGE"; exit status 1 when a required property is missing. The two JSON-LD contexts
that a crate names are given here, as far as our crates use them: what is not listed is a mistake.
"""

import json
import sys

from rdflib.plugins.shared.jsonld import context as jsonld_context
from rdflib.plugins.shared.jsonld import util as jsonld_util
from rocrate_validator import models, services
from rocrate_validator.utils import document_loader
from rocrate_validator.utils.http import HttpRequester

SCHEMA = "http://schema.org/"
BIOSCHEMAS = "https://bioschemas.org/"
WORKFLOW_RUN = "https://w3id.org/ro/terms/workflow-run#"
TERMS = """
CreativeWork Dataset SoftwareApplication SoftwareSourceCode HowTo HowToStep ComputerLanguage PropertyValue CreateAction
ControlAction OrganizeAction about actionStatus additionalProperty additionalType contentSize datePublished description encodingFormat endTime
error exampleOfWork hasPart instrument license mainEntity mentions name object position programmingLanguage result softwareVersion
startTime step unitText url value version workExample
""".split()
CONTEXTS = {
    "https://w3id.org/ro/crate/1.1/context": {"@context": {
        **{term: SCHEMA + term for term in TERMS},
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


class Answer:
    """As requests would give it."""

    status_code, ok, headers = 200, True, {"Content-Type": "application/ld+json"}

    def __init__(self, document):
        self._document = document
        self.text = json.dumps(document)
        self.content = self.text.encode()

    def json(self):
        return self._document


HttpRequester.get = lambda self, url, *more, **named: Answer(CONTEXTS[url])
HttpRequester.head = HttpRequester.get

required = False
for directory in sys.argv[1:]:
    settings = services.ValidationSettings(
        rocrate_uri=directory, profile_identifier="provenance-run-crate-0.5", requirement_severity=models.Severity.RECOMMENDED,
        abort_on_first=False)
    for issue in services.validate(settings).get_issues():
        required |= issue.severity == models.Severity.REQUIRED
        print(issue.severity.name, issue.check.identifier, issue.message.replace("\n", " "))
sys.exit(1 if required else 0)
